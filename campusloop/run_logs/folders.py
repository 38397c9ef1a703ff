"""Which runs lie in a folder: of a vehicle's disk, of a demo or of scenarios, and a server's copies."""

import hashlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from contract.runlog.extent import extent
from contract.runlog.reader import RunLogError, open_segment
from contract.runlog.records import RunHeader

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
# A server names a segment by the SHA-256 of its bytes, below a folder of the first two digits.
_COPY = re.compile(r"[0-9a-f]{64}")


class RunNotFound(Exception):
    """There is no such run, or more than one; the text says what to do."""


@dataclass(frozen=True, slots=True)
class RecordedSegment:
    """One file of a run. first_ns, last_ns: its log times (UTC), 0 without a message."""

    path: Path
    header: RunHeader
    size_bytes: int
    first_ns: int
    last_ns: int


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """One vehicle and one boot. segments: at least one, by number; folder: where they lie."""

    folder: Path
    segments: tuple[RecordedSegment, ...]

    @property
    def header(self) -> RunHeader:
        return self.segments[0].header

    @property
    def name(self) -> str:
        return f"{self.header.vehicle_id}/{self.header.boot_id}"

    @property
    def first_ns(self) -> int:
        return min((one.first_ns for one in self.segments if one.first_ns), default=0)

    @property
    def last_ns(self) -> int:
        return max(one.last_ns for one in self.segments)

    @property
    def began_at(self) -> datetime:
        return utc_of(self.first_ns)

    @property
    def duration_s(self) -> float:
        return (self.last_ns - self.first_ns) * 1e-9

    @property
    def size_bytes(self) -> int:
        return sum(one.size_bytes for one in self.segments)

    @property
    def paths(self) -> tuple[Path, ...]:
        return tuple(one.path for one in self.segments)

    @property
    def missing_numbers(self) -> tuple[int, ...]:
        """The segments between the first and the last that are not here."""
        numbers = [one.header.segment for one in self.segments]
        return tuple(sorted(set(range(numbers[0], numbers[-1])) - set(numbers)))


@dataclass(frozen=True, slots=True)
class RunsFound:
    """runs: newest first; unreadable: for each file that cannot be used, why."""

    runs: tuple[RecordedRun, ...]
    unreadable: Mapping[Path, RunLogError]

    def unreadable_of(self, run: RecordedRun) -> tuple[RunLogError, ...]:
        """Of the files beside the run's: they may belong to it."""
        return tuple(error for path, error in self.unreadable.items() if path.parent == run.folder)


def utc_of(log_ns: int) -> datetime:
    """An aware datetime of a log time, to the microsecond."""
    return _EPOCH + timedelta(microseconds=log_ns // 1_000)


def runs_found(place: Path) -> RunsFound:
    """The runs of a segment, or of all segments below a folder. Raises RunNotFound if there are none."""
    if not place.exists():
        raise RunNotFound(
            f"there is no {place}; name a folder with run logs: those of `campusloop demo` are "
            "in var/demo, where it was started"
        )
    paths = sorted(place.rglob("*.mcap")) if place.is_dir() else [place]
    if not paths:
        raise RunNotFound(
            f"{place}: no run logs (*.mcap) there; a vehicle's lie in VEHICLE/runs, those of "
            "`campusloop demo` in var/demo"
        )
    groups: dict[tuple[Path, str, str], dict[int, RecordedSegment]] = {}
    unreadable: dict[Path, RunLogError] = {}
    for path in paths:
        try:
            segment = _segment(path)
        except RunLogError as error:
            unreadable[path] = error
            continue
        key = (_folder(path), segment.header.vehicle_id, segment.header.boot_id)
        groups.setdefault(key, {})[segment.header.segment] = segment
    kept = [segments for segments in groups.values() if not _are_copies(segments, groups.values())]
    runs = [
        RecordedRun(
            _folder(segments[min(segments)].path), tuple(segments[number] for number in sorted(segments))
        )
        for segments in kept
    ]
    runs.sort(key=lambda run: (-run.first_ns, run.name, str(run.folder)))
    return RunsFound(tuple(runs), unreadable)


def one_run(named: str, place: Path) -> tuple[RecordedRun, tuple[RunLogError, ...]]:
    """The run of a segment or folder, or the one that is called VEHICLE/BOOT below `place`.

    With it, why files beside it cannot be used. Raises RunNotFound, and RunLogError if none can.
    """
    path = Path(named)
    if path.exists():
        found = runs_found(path)
        chosen = found.runs
        if not chosen:
            raise next(iter(found.unreadable.values()))
    else:
        found = runs_found(place)
        chosen = tuple(run for run in found.runs if run.name == named)
    if not chosen:
        raise RunNotFound(f"no run {named} in {place}; `campusloop runs list {place}` shows the runs there")
    if len(chosen) > 1:
        several = "\n".join(f"  {_shortest(run)}" for run in chosen)
        raise RunNotFound(f"{named} is {len(chosen)} runs; name one of them by its files:\n{several}")
    return chosen[0], found.unreadable_of(chosen[0])


def _shortest(run: RecordedRun) -> Path:
    """What to name so that only this run is meant: its folder, or a segment in a folder of several runs."""
    return run.paths[0] if _COPY.fullmatch(run.paths[0].stem) else run.folder


def _segment(path: Path) -> RecordedSegment:
    """Raises RunLogError."""
    header = open_segment(path).header
    first_ns, last_ns = extent(path)
    return RecordedSegment(path, header, path.stat().st_size, first_ns, last_ns)


def _folder(path: Path) -> Path:
    """The folder that holds the whole run."""
    return path.parent.parent if _COPY.fullmatch(path.stem) else path.parent


def _are_copies(
    segments: Mapping[int, RecordedSegment], groups: Iterable[Mapping[int, RecordedSegment]]
) -> bool:
    """All of them are a server's copies of segments that were found elsewhere."""
    if not all(_COPY.fullmatch(one.path.stem) for one in segments.values()):
        return False
    hashes = {one.path.stem for one in segments.values()}
    sizes = {one.size_bytes for one in segments.values()}
    others = [
        one
        for group in groups
        if group is not segments
        for one in group.values()
        if one.size_bytes in sizes and not _COPY.fullmatch(one.path.stem)
    ]
    return hashes <= {hashlib.sha256(one.path.read_bytes()).hexdigest() for one in others}
