"""The compiled kernels on disk: which of them still hold, and which groups are complete.

Numba keeps them beside the sources and starts a file's kernels afresh when that file was written. It does not
notice that a kernel, constant or class of another file has changed, so those caches are deleted here.
"""

import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from platform import python_version

import msgspec

from campusloop.kernels.groups import GROUPS, Group
from campusloop.kernels.sources import Sources

_LIBRARIES = ("numba", "llvmlite", "numpy")
# Among numba's own files: who deletes those deletes it too.
_RECORD = Path("campusloop") / "__pycache__" / "kernels.json"
_INDEX, _DATA = "nbi", "nbc"


class Complete(msgspec.Struct, frozen=True):
    """A group that was compiled whole.

    sources: what it was compiled from; files: numba's indexes
    """

    sources: str
    files: tuple[str, ...]


class Record(msgspec.Struct):
    """written: each source file's moment and size; kernels: by module, what its kernels are made of."""

    written: dict[str, tuple[int, int]] = {}
    libraries: tuple[str, ...] = ()
    kernels: dict[str, str] = {}
    complete: dict[str, Complete] = {}


class KernelCaches:
    """The caches of the sources below `root`. deleted: how many modules' caches did not hold any more."""

    def __init__(self, sources: Sources, groups: Mapping[str, Group] = GROUPS) -> None:
        self._sources = sources
        self._groups = groups
        self._path = sources.root / _RECORD
        self._record = self._read()
        self.deleted = 0

    def missing(self, groups: tuple[str, ...]) -> tuple[str, ...]:
        """The groups that are not complete, in the order of all; caches that hold no more are deleted."""
        self._look()
        return tuple(name for name in self._groups if name in groups and not self._is_complete(name))

    def note(self, group: str) -> None:
        """A group has been compiled whole, from the sources that `missing` has looked at."""
        modules = self._modules(group)
        files = tuple(str(path) for module in modules for path in self._files(module, _INDEX))
        self._record.complete[group] = Complete(self._digest(modules), files)
        self._write()

    def _look(self) -> None:
        written = {name: _written(module.path) for name, module in self._sources.modules.items()}
        libraries = (python_version(), *(version(name) for name in _LIBRARIES))
        if (written, libraries) == (self._record.written, self._record.libraries):
            return
        kernels = {
            name: f"{self._sources.mark(name)} {written[name]} {libraries}" for name in self._sources.kernels
        }
        for name, mark in kernels.items():
            if self._record.kernels.get(name) != mark:
                found = self._files(name, _INDEX) + self._files(name, _DATA)
                for path in found:
                    path.unlink(missing_ok=True)
                self.deleted += bool(found)
        self._record.written, self._record.libraries, self._record.kernels = written, libraries, kernels
        self._write()

    def _is_complete(self, group: str) -> bool:
        complete = self._record.complete.get(group)
        if complete is None or not all(Path(file).exists() for file in complete.files):
            return False
        return complete.sources == self._digest(self._modules(group))

    def _modules(self, group: str) -> list[str]:
        """The modules with kernels that the group's warming may reach."""
        return sorted(self._sources.imported(self._groups[group].module) & self._record.kernels.keys())

    def _digest(self, modules: list[str]) -> str:
        return " ".join(f"{name} {self._record.kernels[name]}" for name in modules)

    def _files(self, module: str, kind: str) -> list[Path]:
        source = self._sources.modules[module].path
        return sorted((source.parent / "__pycache__").glob(f"{source.stem}.*.{kind}"))

    def _read(self) -> Record:
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=Record)
        except (FileNotFoundError, msgspec.DecodeError):
            # Then nothing is known of what is there, and it is compiled again.
            return Record()

    def _write(self) -> None:
        """Whole or not at all: two commands may be at it."""
        self._path.parent.mkdir(exist_ok=True)
        draft = self._path.with_suffix(f".{os.getpid()}")
        draft.write_bytes(msgspec.json.encode(self._record))
        draft.replace(self._path)


def _written(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_mtime_ns, status.st_size
