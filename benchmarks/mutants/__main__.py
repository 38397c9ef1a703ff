"""Mutation testing of the short tests: `python -m benchmarks.mutants --sample N --seed S [--room R ...]`.

A sample of all small wrong changes (a comparison at its boundary, a sign, a number, a condition turned round)
to the rooms is drawn, the same share of each room. Each change is applied alone in a private copy of the
tree; then the short tests run, those that mirror the room first. A change that no test detects is a survivor:
a row with the line before and after. Equivalent changes, which no test can detect, are listed in
equivalents.json with their reasons; they do not count.
"""

import argparse
import json
import os
import random
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from benchmarks.mutants.importers import ImportGraph
from benchmarks.mutants.mutations import MutatedFile, Mutation, mutated, mutations_of
from benchmarks.mutants.private_copy import PrivateCopy
from benchmarks.mutants.rooms import ROOMS, ROOT, Room
from benchmarks.mutants.selection import test_files
from benchmarks.reporting.report import Row, RunReport

EQUIVALENTS = Path(__file__).with_name("equivalents.json")
# A change that makes the tests so many times slower has been noticed.
_SLOWER_MAX = 6.0
_LIMIT_S_MIN = 120.0
_UNCHANGED_LIMIT_S = 3600.0
# Files of tests that are tried together before any change.
_TOGETHER = 10


@dataclass(frozen=True, slots=True)
class Trial:
    room: Room
    mutation: Mutation
    change: MutatedFile
    killed: bool
    took_s: float

    def row(self) -> Row:
        """Of a survivor."""
        return {
            "room": self.room.name,
            "line": f"{self.mutation.path}:{self.change.line}",
            "was": self.change.was,
            "now": self.change.now,
        }


class TestsBroken(Exception):
    """Tests fail without any change; the message has their last lines."""


class Trials:
    """Tries changes, each thread in a copy of its own."""

    def __init__(self, folder: Path, graph: ImportGraph, mirror_only: bool) -> None:
        self._folder = folder
        self._graph = graph
        self._mirror_only = mirror_only
        self._mine = threading.local()
        self._lock = threading.Lock()
        self._copies = 0
        self._unchanged_s: dict[str, float] = {}

    def rounds(self, room: Room, mutation: Mutation) -> list[tuple[tuple[str, ...], bool]]:
        """The tests that are tried first, then the others; and whether they run on PostgreSQL, too."""
        near, others = test_files(self._graph, room, mutation.path)
        rounds = [(near, room.on_postgresql), (() if self._mirror_only else others, False)]
        return [(tests, on_postgresql) for tests, on_postgresql in rounds if tests]

    def time_unchanged(self, tests: Sequence[str], on_postgresql: bool) -> None:
        """Raises TestsBroken when one of them fails without any change."""
        begun = time.monotonic()
        failure = self._copy().failure(tests, _UNCHANGED_LIMIT_S, on_postgresql)
        if failure:
            raise TestsBroken(f"fails without any change: {failure}")
        took_s = time.monotonic() - begun
        print(f"unchanged {took_s:.0f} s {tests[0]} and {len(tests) - 1} more", flush=True)
        self._unchanged_s |= {path: took_s / len(tests) for path in tests}

    def run(self, room: Room, mutation: Mutation) -> Trial:
        copy = self._copy()
        change = mutated(mutation, copy.text(mutation.path))
        begun = time.monotonic()
        with copy.changed(mutation.path, change.text):
            killed = any(
                copy.failure(tests, self._limit_s(tests), on_postgresql)
                for tests, on_postgresql in self.rounds(room, mutation)
            )
        trial = Trial(room, mutation, change, killed, time.monotonic() - begun)
        outcome = "killed" if killed else "SURVIVED"
        print(f"{outcome} {trial.took_s:.0f} s {room.name} {change.key(mutation.path)}", flush=True)
        return trial

    def _limit_s(self, tests: Sequence[str]) -> float:
        return max(_LIMIT_S_MIN, _SLOWER_MAX * sum(self._unchanged_s[path] for path in tests))

    def _copy(self) -> PrivateCopy:
        if not hasattr(self._mine, "copy"):
            with self._lock:
                self._copies += 1
                folder = self._folder / f"copy-{self._copies}"
            self._mine.copy = PrivateCopy(folder, self._graph)
        copy: PrivateCopy = self._mine.copy
        return copy


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(prog="benchmarks.mutants")
    parser.add_argument("--sample", type=int, default=300, metavar="N", help="so many changes (300)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--room", action="append", choices=[room.name for room in ROOMS], metavar="ROOM")
    parser.add_argument(
        "--mirror-only", action="store_true", help="only tests that mirror the room: quicker, and stricter"
    )
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument(
        "--floor", type=float, default=0.0, metavar="PCT", help="exit 1 when fewer are killed"
    )
    parser.add_argument("--room-floor", type=float, default=0.0, metavar="PCT", help="the same of each room")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    rooms = [room for room in ROOMS if arguments.room is None or room.name in arguments.room]
    known: dict[str, str] = json.loads(EQUIVALENTS.read_text(encoding="utf-8"))
    drawn = draw(rooms, arguments.sample, arguments.seed, known)
    with tempfile.TemporaryDirectory(prefix="campusloop-mutants-") as folder:
        trials = Trials(Path(folder), ImportGraph(ROOT), arguments.mirror_only)
        with ThreadPoolExecutor(arguments.processes) as pool:
            list(pool.map(lambda some: trials.time_unchanged(*some), batches(trials, drawn)))
            done = list(pool.map(lambda one: trials.run(*one), drawn))
    figures = summary(done)
    report.write(
        arguments.json,
        "mutants",
        {
            "sample": arguments.sample,
            "seed": arguments.seed,
            "rooms": [room.name for room in rooms],
            "mirror_only": arguments.mirror_only,
        },
        [trial.row() for trial in done if not trial.killed],
        figures,
    )
    if figures["killed_pct"] < arguments.floor or figures["worst_room_pct"] < arguments.room_floor:
        sys.exit("the short tests notice too few wrong changes")


def batches(trials: Trials, drawn: Sequence[tuple[Room, Mutation]]) -> Iterator[tuple[list[str], bool]]:
    """All tests that the trials may take, some at a time, and whether they run on PostgreSQL, too."""
    wanted: dict[bool, set[str]] = {True: set(), False: set()}
    for room, mutation in drawn:
        for tests, on_postgresql in trials.rounds(room, mutation):
            wanted[on_postgresql].update(tests)
    for on_postgresql, tests in ((True, wanted[True]), (False, wanted[False] - wanted[True])):
        some = iter(sorted(tests))
        while together := list(islice(some, _TOGETHER)):
            yield together, on_postgresql


def draw(
    rooms: Sequence[Room], sample: int, seed: int, equivalents: dict[str, str]
) -> list[tuple[Room, Mutation]]:
    """The same number from every room, as far as it has so many; those known as equivalent left out."""
    drawn: list[tuple[Room, Mutation]] = []
    for number, room in enumerate(rooms):
        share = (sample * (number + 1)) // len(rooms) - (sample * number) // len(rooms)
        texts = {path: (ROOT / path).read_text(encoding="utf-8") for path in room.files()}
        found = [mutation for path, text in texts.items() for mutation in mutations_of(path, text)]
        random.Random(f"{seed} {room.name}").shuffle(found)
        counted = (m for m in found if mutated(m, texts[m.path]).key(m.path) not in equivalents)
        drawn += [(room, mutation) for mutation in islice(counted, share)]
    return drawn


def summary(done: Sequence[Trial]) -> dict[str, Any]:
    """Shares of killed changes: of all, of each room, and of the worst room."""
    rooms: dict[str, list[bool]] = {}
    for trial in done:
        rooms.setdefault(trial.room.name, []).append(trial.killed)
    shares = {name: 100.0 * sum(killed) / len(killed) for name, killed in rooms.items()}
    return {
        "mutants": len(done),
        "killed": sum(trial.killed for trial in done),
        "killed_pct": 100.0 * sum(trial.killed for trial in done) / len(done),
        "worst_room_pct": min(shares.values()),
        **{f"{name}.killed_pct": share for name, share in shares.items()},
    }


if __name__ == "__main__":
    main()
