"""What has to be the same on all machines of a campaign, and the check that it is."""

import hashlib
import platform
import socket
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

_ROOT = Path(__file__).resolve().parents[2]
_PACKAGES = ("benchmarks", "campusloop", "contract", "server", "simulator", "vehicle_agent")
_SOURCES = (".py", ".toml", ".dbc")
# A last bit that these compute differently changes a drive.
_LIBRARIES = ("numba", "numpy", "scipy", "osqp", "piqp", "highspy", "shapely", "msgspec")


class WorkerDiffers(Exception):
    """A worker has another installation or other files; the message says which."""


@dataclass(frozen=True, slots=True)
class Installation:
    """python: its version; code: a digest of the project's sources; libraries: versions by name."""

    python: str
    code: str
    libraries: dict[str, str]


@cache
def installation() -> Installation:
    """This process's installation."""
    return Installation(
        platform.python_version(), _code_digest(), {name: _version(name) for name in _LIBRARIES}
    )


def file_digests(paths: Iterable[Path]) -> dict[str, str]:
    """SHA-256 by absolute path: of the files, and of all files below the folders. Raises OSError."""
    found = {}
    for path in paths:
        inside = sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]
        for one in inside:
            with one.open("rb") as file:
                found[str(one.absolute())] = hashlib.file_digest(file, "sha256").hexdigest()
    return found


@dataclass(frozen=True)
class CheckedCall:
    """A function that first checks, once in each worker, that the worker computes what the caller would.

    files   digests by path: inputs that the jobs name by their paths
    """

    function: Callable[[Any], Any]
    expected: Installation
    files: dict[str, str] = field(default_factory=dict)
    prepare: Callable[[], None] | None = None

    def __call__(self, job: Any) -> Any:
        key = (self.expected.code, tuple(sorted(self.files.items())), self.prepare)
        if key not in _CHECKED:
            self._check()
            if self.prepare is not None:
                self.prepare()
            _CHECKED.add(key)
        return self.function(job)

    def _check(self) -> None:
        here, host = installation(), socket.gethostname()
        if here != self.expected:
            raise WorkerDiffers(
                f"the worker on {host} has another installation: {_differences(self.expected, here)}"
            )
        for path, digest in self.files.items():
            try:
                found = file_digests([Path(path)]).get(path)
            except OSError as error:
                raise WorkerDiffers(f"the worker on {host} cannot read {path}: {error.strerror}") from error
            if found != digest:
                raise WorkerDiffers(f"the worker on {host} has other content in {path}")


_CHECKED: set[object] = set()


def _differences(expected: Installation, here: Installation) -> str:
    pairs = [("Python", expected.python, here.python)]
    pairs += [
        (name, expected.libraries[name], here.libraries.get(name, "none")) for name in expected.libraries
    ]
    found = [f"{name} {there} instead of {wanted}" for name, wanted, there in pairs if there != wanted]
    return ", ".join(found) or "other sources of Campusloop"


def _code_digest() -> str:
    digest = hashlib.sha256()
    for package in _PACKAGES:
        for path in sorted((_ROOT / package).rglob("*")):
            if path.suffix in _SOURCES:
                digest.update(f"{path.relative_to(_ROOT)}\n".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"
