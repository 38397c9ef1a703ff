"""What a module's kernels are compiled from, by reading sources: nothing is imported.

A compiled kernel holds the kernels that it calls, the constants it names and the fields of its arguments'
classes, in whichever file. Numba looks at the kernel's own file alone.
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
    """One source file. name: as it is imported."""

    name: str
    path: Path

    @cached_property
    def _tree(self) -> ast.Module:
        return ast.parse(self.path.read_bytes(), str(self.path))

    @cached_property
    def statements(self) -> dict[str, list[ast.stmt]]:
        """What each name of the module is made by, in order."""
        made: dict[str, list[ast.stmt]] = {}
        for statement in _top_level(self._tree.body):
            for name in _names_made(statement):
                made.setdefault(name, []).append(statement)
        return made

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
    """The files of some packages. root: the folder that holds the packages."""

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
        """By module, the names of its kernels: functions with a decorator from numba, or with one of ours
        that uses it."""
        found = {}
        for name, module in self.modules.items():
            names = tuple(
                made
                for made, statements in module.statements.items()
                if any(self._is_kernel(module, statement) for statement in statements)
            )
            if names:
                found[name] = names
        return found

    def mark(self, name: str) -> str:
        """A digest of all that the module's kernels are compiled from; comments and layout do not count."""
        digest = hashlib.sha256()
        for module_name, made in sorted(self._behind((name, kernel) for kernel in self.kernels[name])):
            module = self.modules[module_name]
            if made == _WHOLE:
                text = module.dump
            else:
                text = "\n".join(ast.dump(statement) for statement in module.statements[made])
            digest.update(f"{module_name}:{made}\n{text}\n".encode())
        return digest.hexdigest()

    def imported(self, name: str) -> frozenset[str]:
        """Our modules that importing this one may bring along, itself included."""
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
        used = {name for decorator in statement.decorator_list for name in _names_used(decorator)}
        return any(self._comes_from_numba(module, name) for name in used)

    def _comes_from_numba(self, module: Module, name: str) -> bool:
        for module_name, made in self._behind([(module.name, name)]):
            for statement in self.modules[module_name].statements.get(made, []):
                if isinstance(statement, ast.ImportFrom) and statement.module == _NUMBA:
                    return True
                if isinstance(statement, ast.Import) and any(a.name == _NUMBA for a in statement.names):
                    return True
        return False

    def _behind(self, definitions: Iterable[Definition]) -> set[Definition]:
        """These definitions and all that they name, directly or not, as far as it is ours."""
        found: set[Definition] = set()
        waiting = [definition for definition in definitions if self._is_ours(definition)]
        while waiting:
            definition = waiting.pop()
            if definition in found:
                continue
            found.add(definition)
            waiting += [other for other in self._named_by(definition) if self._is_ours(other)]
        return found

    def _is_ours(self, definition: Definition) -> bool:
        module = self.modules.get(definition[0])
        return module is not None and (definition[1] == _WHOLE or definition[1] in module.statements)

    def _named_by(self, definition: Definition) -> Iterator[Definition]:
        module = self.modules[definition[0]]
        names = module.statements if definition[1] == _WHOLE else [definition[1]]
        for name in names:
            for statement in module.statements[name]:
                if isinstance(statement, ast.Import):
                    for alias in statement.names:
                        yield (alias.name, _WHOLE)
                elif isinstance(statement, ast.ImportFrom):
                    yield from self._imported_by(statement, name)
                else:
                    for used in _names_used(statement):
                        yield (module.name, used)

    def _imported_by(self, statement: ast.ImportFrom, name: str) -> Iterator[Definition]:
        origin = statement.module or ""
        for alias in statement.names:
            if (alias.asname or alias.name) != name:
                continue
            if f"{origin}.{alias.name}" in self.modules:
                yield (f"{origin}.{alias.name}", _WHOLE)
            elif self._is_ours((origin, alias.name)):
                yield (origin, alias.name)
            else:
                # Made in a way that is not seen here.
                yield (origin, _WHOLE)


def _top_level(statements: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """Also those under `if`, `try` and `with`, which make names of the module as well."""
    for statement in statements:
        if isinstance(statement, ast.If | ast.Try | ast.With):
            yield from _top_level(
                node for node in ast.iter_child_nodes(statement) if isinstance(node, ast.stmt)
            )
            for handler in getattr(statement, "handlers", []):
                yield from _top_level(handler.body)
        else:
            yield statement


def _names_made(statement: ast.stmt) -> Iterator[str]:
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


def _names_used(node: ast.AST) -> Iterator[str]:
    """Also those in annotations that are written as strings."""
    for part in ast.walk(node):
        if isinstance(part, ast.Name):
            yield part.id
        for note in (getattr(part, "annotation", None), getattr(part, "returns", None)):
            for text in ast.walk(note) if isinstance(note, ast.AST) else ():
                if isinstance(text, ast.Constant) and isinstance(text.value, str):
                    yield from _names_used(ast.parse(text.value, mode="eval"))
