"""A copy of the tree in which one file at a time is changed, and the tests that are run in it."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from benchmarks.mutants.importers import ImportGraph
from benchmarks.mutants.rooms import ROOT

SHORT = "not real and not browser and not faults and not long"
_LEFT_OUT = (".git", ".venv", "node_modules", "var", "dist", ".*_cache", ".hypothesis")
# Of one test that loops for ever; the slowest short test takes a tenth of it.
_TEST_LIMIT_S = 120
# Pytest's exit status where no test is left to run.
_NO_SHORT_TEST = 5


class PrivateCopy:
    """Belongs to one thread. The checkout is only read."""

    def __init__(self, folder: Path, graph: ImportGraph) -> None:
        self.folder = folder
        self._graph = graph
        self._changes = 0
        shutil.copytree(ROOT, folder, symlinks=True, ignore=shutil.ignore_patterns(*_LEFT_OUT))

    def text(self, path: str) -> str:
        return (self.folder / path).read_text(encoding="utf-8")

    @contextmanager
    def changed(self, path: str, text: str) -> Iterator[None]:
        """The file has this text inside, and machine code compiled with the old one is out of the way."""
        file = self.folder / path
        before, stat = file.read_bytes(), file.stat()
        stash = self.folder.parent / f"{self.folder.name}-compiled"
        compiled = [found for other in self._graph.compiled_with(path) for found in self._compiled(other)]
        stash.mkdir()
        for number, found in enumerate(compiled):
            shutil.move(found, stash / str(number))
        self._changes += 1
        file.write_text(text, encoding="utf-8")
        # Python and Numba tell old code by its file's time, in seconds: no two changes share theirs.
        changed_ns = stat.st_mtime_ns + 10**9 * (3600 + self._changes)
        os.utime(file, ns=(changed_ns, changed_ns))
        try:
            yield
        finally:
            file.write_bytes(before)
            os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))
            for other in self._graph.compiled_with(path):
                for found in self._compiled(other):
                    found.unlink()
            for number, found in enumerate(compiled):
                shutil.move(stash / str(number), found)
            stash.rmdir()

    def failure(self, tests: Sequence[str], limit_s: float, on_postgresql: bool) -> str:
        """The end of what pytest says about the first test that fails; "" when all of these files pass.

        Pytest itself failing counts as well: a change in a kernel may end its process.
        """
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-m", SHORT, "-p", "no:cacheprovider"]
        command += ["--no-header", "--tb=line", f"--timeout={_TEST_LIMIT_S}"]
        if not on_postgresql:
            command += ["-k", "not postgresql"]
        process = subprocess.Popen(
            [*command, *tests],
            cwd=self.folder,
            env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": ""},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            said, _ = process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            return f"not over after {limit_s:.0f} s"
        finally:
            _end(process)
        if process.returncode in (0, _NO_SHORT_TEST):
            return ""
        return f"exit {process.returncode}: {said[-1500:]}"

    def _compiled(self, path: str) -> list[Path]:
        """What Numba keeps of the file's kernels."""
        file = self.folder / path
        return sorted((file.parent / "__pycache__").glob(f"{file.stem}.*.nb[ic]"))


def _end(process: subprocess.Popen[str]) -> None:
    """The tests and whatever they have started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
