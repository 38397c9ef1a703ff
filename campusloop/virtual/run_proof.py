"""Replay of every recorded segment, on the cores that the campus leaves idle."""

import multiprocessing
import os
import time
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from contract.runlog.reader import RunLogError
from server.supervision.parent_end import end_with_parent
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

PRINT_EVERY_S = 10.0


@dataclass(frozen=True, slots=True)
class Proof:
    """The result of one replayed segment. flaw: how it differs or why it cannot be read; "" for none."""

    path: Path
    ticks: int
    flaw: str


class RunProof:
    """Replays segments while the campus records further ones."""

    def __init__(self, folder: Path) -> None:
        """folder: every segment below it is replayed."""
        self._folder = folder
        # A fork would copy the running campus.
        spawning = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(
            os.cpu_count() or 1, mp_context=spawning, initializer=end_with_parent
        )
        self._begun: dict[Path, Future[Proof]] = {}

    def __enter__(self) -> "RunProof":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.shutdown(cancel_futures=True)

    def replay_closed(self) -> None:
        """Start to replay the closed segments: all but the last one of each boot."""
        for boot in {path.parent for path in self._folder.rglob("*.mcap")}:
            for path in sorted(boot.glob("*.mcap"))[:-1]:
                self._begin(path)

    def results(self, console: Console) -> list[Proof]:
        """Replay the rest and return all results, in the order of the paths. Call it after the last run."""
        paths = sorted(self._folder.rglob("*.mcap"))
        for path in paths:
            self._begin(path)
        results = []
        printer = IntervalPrinter(console)
        with virtual_progress(console) as progress:
            bar = progress.add_task("replaying runs", total=len(paths), clock="")
            for number, path in enumerate(paths):
                printer.print(f"replaying the runs: {number} of {len(paths)} segments are done")
                results.append(self._begun[path].result())
                progress.advance(bar)
        return results

    @property
    def replayed(self) -> int:
        """Segments that have been replayed so far."""
        return sum(future.done() for future in self._begun.values())

    def _begin(self, path: Path) -> None:
        if path not in self._begun:
            self._begun[path] = self._pool.submit(prove, path)


def prove(path: Path) -> Proof:
    """Replay one segment; a damaged log is a flaw too."""
    try:
        result = replay_segment(path, build_car)
    except RunLogError as error:
        return Proof(path, 0, str(error))
    flaw = f"differs at {result.difference}" if result.difference is not None else result.cut_short
    return Proof(path, result.ticks, flaw)


def flaws(proofs: list[Proof]) -> list[str]:
    """The segments that did not replay as recorded, and why."""
    return [f"{proof.path}: {proof.flaw}" for proof in proofs if proof.flaw]


class IntervalPrinter:
    """Prints a progress line at most once per interval, where the console is no terminal."""

    def __init__(self, console: Console, every_s: float = PRINT_EVERY_S) -> None:
        self._console = console
        self._every_s = every_s
        self._due_s = time.monotonic() + every_s

    def print(self, text: str) -> None:
        """Print the text if the interval since the last line is over."""
        if self._console.is_terminal or time.monotonic() < self._due_s:
            return
        self._due_s = time.monotonic() + self._every_s
        self._console.print(text, highlight=False, soft_wrap=True)


def virtual_progress(console: Console) -> Progress:
    """A bar with a count, the campus's clock and the elapsed time; add_task(..., clock=...)."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed}/{task.total} {task.fields[clock]}"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        # Drawing slows down the campus, which runs in the same process.
        refresh_per_second=2,
    )
