"""The definitions that a module's kernels depend on, found by parsing the sources without importing them.

A compiled kernel contains the kernels that it calls, the constants it names and the fields of its arguments'
classes, from all files. Numba checks only the kernel's own file.
"""

import ast
import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

_NUMBA = "numba"
# A definition: the name of its module and its own name there; "" for the whole module.
Definition = tuple[str, str]
_WHOLE = ""


@dataclass(frozen=True)
class Module:
    """One source file. name: its name in import statements."""

    name: str
    path: Path

    @cached_property
    def _tree(self) -> ast.Module:
        return ast.parse(self.path.read_bytes(), str(self.path))

    @cached_property
    def statements(self) -> dict[str, list[ast.stmt]]:
        """The statements that define each name of the module, in order."""
        defining: dict[str, list[ast.stmt]] = {}
        for statement in _top_level(self._tree.body):
            for name in _defined_names(statement):
                defining.setdefault(name, []).append(statement)
        return defining

    @cached_property
    def dump(self) -> str:
        return ast.dump(self._tree)

    @cached_property
    def imports(self) -> frozenset[str]:
        """Modules that are named in imports anywhere in the file; "a.b" for `from a import b`, too."""
        found: set[str] = set()
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                found.add(node.module)
                found |= {f"{node.module}.{alias.name}" for alias in node.names}
        return frozenset(found)


@dataclass(frozen=True)
class Sources:
    """The files of some packages. root: the folder with the packages."""

    root: Path
    packages: tuple[str, ...]

    @cached_property
    def modules(self) -> dict[str, Module]:
        found = {}
        for package in self.packages:
            for path in sorted((self.root / package).rglob("*.py")):
                parts = list(path.relative_to(self.root).with_suffix("").parts)
                if parts[-1] == "__init__":
                    parts.pop()
                name = ".".join(parts)
                found[name] = Module(name, path)
        return found

    @cached_property
    def kernels(self) -> dict[str, tuple[str, ...]]:
        """By module, the names of its kernels: functions with a decorator from numba, or with a decorator of
        the packages that uses numba."""
        found = {}
        for name, module in self.modules.items():
            names = tuple(
                defined
                for defined, statements in module.statements.items()
                if any(self._is_kernel(module, statement) for statement in statements)
            )
            if names:
                found[name] = names
        return found

    def digest(self, name: str) -> str:
        """A digest of all definitions that the module's kernels depend on, without comments and layout."""
        digest = hashlib.sha256()
        kernels = ((name, kernel) for kernel in self.kernels[name])
        for module_name, defined in sorted(self._dependencies(kernels)):
            module = self.modules[module_name]
            if defined == _WHOLE:
                text = module.dump
            else:
                text = "\n".join(ast.dump(statement) for statement in module.statements[defined])
            digest.update(f"{module_name}:{defined}\n{text}\n".encode())
        return digest.hexdigest()

    def imported(self, name: str) -> frozenset[str]:
        """The packages' modules that an import of this one may import, itself included."""
        found: set[str] = set()
        waiting = [name]
        while waiting:
            module = waiting.pop()
            if module in found or module not in self.modules:
                continue
            found.add(module)
            waiting += self.modules[module].imports
        return frozenset(found)

    def _is_kernel(self, module: Module, statement: ast.stmt) -> bool:
        if not isinstance(statement, ast.FunctionDef):
            return False
        used = {name for decorator in statement.decorator_list for name in _used_names(decorator)}
        return any(self._comes_from_numba(module, name) for name in used)

    def _comes_from_numba(self, module: Module, name: str) -> bool:
        for module_name, defined in self._dependencies([(module.name, name)]):
            for statement in self.modules[module_name].statements.get(defined, []):
                if isinstance(statement, ast.ImportFrom) and statement.module == _NUMBA:
                    return True
                if isinstance(statement, ast.Import) and any(a.name == _NUMBA for a in statement.names):
                    return True
        return False

    def _dependencies(self, definitions: Iterable[Definition]) -> set[Definition]:
        """These definitions and all definitions of the packages that they name, directly or indirectly."""
        found: set[Definition] = set()
        waiting = [definition for definition in definitions if self._is_local(definition)]
        while waiting:
            definition = waiting.pop()
            if definition in found:
                continue
            found.add(definition)
            waiting += [other for other in self._names_in(definition) if self._is_local(other)]
        return found

    def _is_local(self, definition: Definition) -> bool:
        module = self.modules.get(definition[0])
        return module is not None and (definition[1] == _WHOLE or definition[1] in module.statements)

    def _names_in(self, definition: Definition) -> Iterator[Definition]:
        module = self.modules[definition[0]]
        names = module.statements if definition[1] == _WHOLE else [definition[1]]
        for name in names:
            for statement in module.statements[name]:
                if isinstance(statement, ast.Import):
                    for alias in statement.names:
                        yield (alias.name, _WHOLE)
                elif isinstance(statement, ast.ImportFrom):
                    yield from self._imports_in(statement, name)
                else:
                    for used in _used_names(statement):
                        yield (module.name, used)

    def _imports_in(self, statement: ast.ImportFrom, name: str) -> Iterator[Definition]:
        origin = statement.module or ""
        for alias in statement.names:
            if (alias.asname or alias.name) != name:
                continue
            if f"{origin}.{alias.name}" in self.modules:
                yield (f"{origin}.{alias.name}", _WHOLE)
            elif self._is_local((origin, alias.name)):
                yield (origin, alias.name)
            else:
                # Defined in a way that the parser does not recognise.
                yield (origin, _WHOLE)


def _top_level(statements: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements, with those under `if`, `try` and `with`, which define names of the module too."""
    for statement in statements:
        if isinstance(statement, ast.If | ast.Try | ast.With):
            yield from _top_level(
                node for node in ast.iter_child_nodes(statement) if isinstance(node, ast.stmt)
            )
            for handler in getattr(statement, "handlers", []):
                yield from _top_level(handler.body)
        else:
            yield statement


def _defined_names(statement: ast.stmt) -> Iterator[str]:
    match statement:
        case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
            yield statement.name
        case ast.Import():
            for alias in statement.names:
                yield alias.asname or alias.name.split(".")[0]
        case ast.ImportFrom():
            for alias in statement.names:
                yield alias.asname or alias.name
        case ast.Assign() | ast.AnnAssign() | ast.AugAssign() | ast.For():
            for node in ast.walk(statement):
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                    yield node.id


def _used_names(node: ast.AST) -> Iterator[str]:
    """The names in a node, with those in annotations that are written as strings."""
    for part in ast.walk(node):
        if isinstance(part, ast.Name):
            yield part.id
        for note in (getattr(part, "annotation", None), getattr(part, "returns", None)):
            for text in ast.walk(note) if isinstance(note, ast.AST) else ():
                if isinstance(text, ast.Constant) and isinstance(text.value, str):
                    yield from _used_names(ast.parse(text.value, mode="eval"))
