"""The caches of compiled kernels: which are still valid, and which groups are complete.

Numba stores them beside the sources and compiles a file's kernels again when that file has changed. It does
not notice a change of a kernel, constant or class in another file, so this module deletes those caches.
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
# Among numba's own files, so that it is deleted together with them.
_RECORD = Path("campusloop") / "__pycache__" / "kernels.json"
_INDEX, _DATA = "nbi", "nbc"


class CachesNotWritable(Exception):
    """The caches lie where this process cannot write, as in a read-only installation."""


class CompleteGroup(msgspec.Struct, frozen=True):
    """A group whose kernels are all compiled.

    sources: digests of its sources; files: numba's index files
    """

    sources: str
    files: tuple[str, ...]


class CacheRecord(msgspec.Struct):
    """written: each source file's modification time and size; kernels: by module, a digest of its sources."""

    written: dict[str, tuple[int, int]] = {}
    libraries: tuple[str, ...] = ()
    kernels: dict[str, str] = {}
    complete: dict[str, CompleteGroup] = {}


class KernelCaches:
    """The caches of the sources. deleted: how many modules had invalid caches.

    The methods raise CachesNotWritable.
    """

    def __init__(self, sources: Sources, groups: Mapping[str, Group] = GROUPS) -> None:
        self._sources = sources
        self._groups = groups
        self._path = sources.root / _RECORD
        self._record = self._read()
        self.deleted = 0

    def missing(self, groups: tuple[str, ...]) -> tuple[str, ...]:
        """The groups that are not complete, in the order of all groups. Deletes invalid caches."""
        self._update()
        return tuple(name for name in self._groups if name in groups and not self._is_complete(name))

    def not_known_complete(self, groups: tuple[str, ...]) -> tuple[str, ...]:
        """The groups of which the record does not say that they are compiled from the present files.

        Reads only. After any change of a file these are all groups, until the next command has looked closer.
        """
        is_present = self._presence() == (self._record.written, self._record.libraries)
        return tuple(name for name in groups if not (is_present and self._is_complete(name)))

    def record_complete(self, group: str) -> None:
        """Record that a group is compiled from the sources that `missing` has read."""
        modules = self._modules(group)
        files = tuple(str(path) for module in modules for path in self._files(module, _INDEX))
        self._record.complete[group] = CompleteGroup(self._digest(modules), files)
        self._write()

    def _update(self) -> None:
        """Delete what was compiled from other sources. Parsing all sources takes a second, so that this is
        done only after a change of a file or a library."""
        written, libraries = self._presence()
        if (written, libraries) == (self._record.written, self._record.libraries):
            return
        kernels = {
            name: f"{self._sources.digest(name)} {written[name]} {libraries}"
            for name in self._sources.kernels
        }
        for name, digest in kernels.items():
            if self._record.kernels.get(name) != digest:
                self.deleted += self._delete(name)
        self._record.written, self._record.libraries, self._record.kernels = written, libraries, kernels
        self._record.complete = {
            group: complete
            for group, complete in self._record.complete.items()
            if group in self._groups and complete.sources == self._digest(self._modules(group))
        }
        self._write()

    def _presence(self) -> tuple[dict[str, tuple[int, int]], tuple[str, ...]]:
        """(when each source file was written and its size, versions of the libraries)"""
        written = {name: _written(module.path) for name, module in self._sources.modules.items()}
        return written, (python_version(), *(version(name) for name in _LIBRARIES))

    def _delete(self, module: str) -> bool:
        """Whether there was anything to delete."""
        found = self._files(module, _INDEX) + self._files(module, _DATA)
        try:
            for path in found:
                path.unlink(missing_ok=True)
        except OSError as error:
            raise CachesNotWritable(str(error)) from error
        return bool(found)

    def _is_complete(self, group: str) -> bool:
        complete = self._record.complete.get(group)
        return complete is not None and all(Path(file).exists() for file in complete.files)

    def _modules(self, group: str) -> list[str]:
        """The modules with kernels that the group's warm function may reach."""
        return sorted(self._sources.imported(self._groups[group].module) & self._record.kernels.keys())

    def _digest(self, modules: list[str]) -> str:
        return " ".join(f"{name} {self._record.kernels[name]}" for name in modules)

    def _files(self, module: str, kind: str) -> list[Path]:
        source = self._sources.modules[module].path
        return sorted((source.parent / "__pycache__").glob(f"{source.stem}.*.{kind}"))

    def _read(self) -> CacheRecord:
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=CacheRecord)
        except (FileNotFoundError, msgspec.DecodeError):
            # The existing caches are then unknown, and everything is compiled again.
            return CacheRecord()

    def _write(self) -> None:
        """Atomic, because two commands may write at the same time."""
        draft = self._path.with_suffix(f".{os.getpid()}")
        try:
            self._path.parent.mkdir(exist_ok=True)
            draft.write_bytes(msgspec.json.encode(self._record))
            draft.replace(self._path)
        except OSError as error:
            raise CachesNotWritable(str(error)) from error


def _written(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_mtime_ns, status.st_size
