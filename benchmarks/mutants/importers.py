"""Which files import which, so that a change is tried only on the tests that can see it."""

import ast
from collections import defaultdict, deque
from collections.abc import Iterator
from pathlib import Path

PACKAGES = ("campusloop", "contract", "server", "simulator", "vehicle_agent", "tests")
_KERNEL_MARKS = ("njit", "@kernel", "@inlined")


class ImportGraph:
    """Files of the tree by their paths relative to its root."""

    def __init__(self, root: Path) -> None:
        self._root = root
        files = [path for package in PACKAGES for path in (root / package).rglob("*.py")]
        self._paths = {str(path.relative_to(root)) for path in files}
        self._importers: dict[str, set[str]] = defaultdict(set)
        self.kernels: set[str] = set()
        for path in sorted(self._paths):
            text = (root / path).read_text(encoding="utf-8")
            if any(mark in text for mark in _KERNEL_MARKS):
                self.kernels.add(path)
            for imported in self._imports(path, ast.parse(text)):
                self._importers[imported].add(path)

    def distances(self, path: str) -> dict[str, int]:
        """How many imports away each file is that imports this one, at whatever remove."""
        found, waiting = {path: 0}, deque([path])
        while waiting:
            one = waiting.popleft()
            for importer in sorted(self._importers[one]):
                if importer not in found:
                    found[importer] = found[one] + 1
                    waiting.append(importer)
        return found

    def compiled_with(self, path: str) -> set[str]:
        """The files of kernels whose machine code has something of this file in it."""
        found, waiting = {path}, [path]
        while waiting:
            for importer in self._importers[waiting.pop()] & self.kernels:
                if importer not in found:
                    found.add(importer)
                    waiting.append(importer)
        return found & self.kernels

    def _imports(self, path: str, tree: ast.Module) -> Iterator[str]:
        if path.startswith("tests/"):
            # pytest gives a test the fixtures of every conftest above it.
            for folder in Path(path).parents:
                conftest = str(folder / "conftest.py")
                if conftest in self._paths and conftest != path:
                    yield conftest
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    yield from self._files(alias.name)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                yield from self._files(node.module)
                for alias in node.names:
                    yield from self._files(f"{node.module}.{alias.name}")

    def _files(self, module: str) -> Iterator[str]:
        stem = module.replace(".", "/")
        for path in (f"{stem}.py", f"{stem}/__init__.py"):
            if path in self._paths:
                yield path
