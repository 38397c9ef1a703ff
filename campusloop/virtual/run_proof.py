"""Every recorded segment run again, on the cores that the campus leaves idle."""

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
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

WORD_EVERY_S = 10.0


@dataclass(frozen=True, slots=True)
class Proof:
    """One segment replayed. flaw: how it differs or why it cannot be read to its end; "" for none."""

    path: Path
    ticks: int
    flaw: str


class RunProof:
    """Replays segments while further ones are still being recorded."""

    def __init__(self, folder: Path) -> None:
        """folder: every segment below it is replayed."""
        self._folder = folder
        # A fork would take the running campus along.
        spawning = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(os.cpu_count() or 1, mp_context=spawning)
        self._begun: dict[Path, Future[Proof]] = {}

    def __enter__(self) -> "RunProof":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.shutdown(cancel_futures=True)

    def look(self) -> None:
        """Begin with the segments that nobody writes to any more: all but the last one of a boot."""
        for boot in {path.parent for path in self._folder.rglob("*.mcap")}:
            for path in sorted(boot.glob("*.mcap"))[:-1]:
                self._begin(path)

    def results(self, console: Console) -> list[Proof]:
        """Once every run has ended: all segments, in the order of their paths."""
        paths = sorted(self._folder.rglob("*.mcap"))
        for path in paths:
            self._begin(path)
        results = []
        word = SpacedWord(console)
        with virtual_progress(console) as progress:
            bar = progress.add_task("replaying runs", total=len(paths), clock="")
            for number, path in enumerate(paths):
                word.say(f"replaying what was driven: {number} of {len(paths)} segments are done")
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
    """Replay one segment; a damaged one is a flaw to be told like any other."""
    try:
        result = replay_segment(path, build_car)
    except RunLogError as error:
        return Proof(path, 0, str(error))
    flaw = f"differs at {result.difference}" if result.difference is not None else result.cut_short
    return Proof(path, result.ticks, flaw)


def flaws(proofs: list[Proof]) -> list[str]:
    """The segments that did not run as recorded to their end, and why."""
    return [f"{proof.path}: {proof.flaw}" for proof in proofs if proof.flaw]


class SpacedWord:
    """What is being done, where no bar can be drawn: a line now and then."""

    def __init__(self, console: Console, every_s: float = WORD_EVERY_S) -> None:
        self._console = console
        self._every_s = every_s
        self._due_s = time.monotonic() + every_s

    def say(self, text: str) -> None:
        """Said when the last word is long enough ago."""
        if self._console.is_terminal or time.monotonic() < self._due_s:
            return
        self._due_s = time.monotonic() + self._every_s
        self._console.print(text, highlight=False, soft_wrap=True)


def virtual_progress(console: Console) -> Progress:
    """A bar with a count, the campus's clock and the time gone by; add_task(..., clock=...)."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed}/{task.total} {task.fields[clock]}"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        # Drawing takes time from the campus, which runs in the same process.
        refresh_per_second=2,
    )
