"""A vehicle's runs on disk: a folder for each boot, in it the segments."""

import hashlib
from pathlib import Path

import msgspec
import zstandard

from contract.runlog.writer import SegmentWriter
from vehicle_agent.runtime.recorder import RunLogEntry, SegmentBegin


class FinishedSegment(msgspec.Struct, frozen=True):
    """A segment that nobody writes to any more, ready to be uploaded by its content's hash."""

    path: str
    sha256: str
    size_bytes: int
    segment: int


class RunLogFiles:
    """Writes a vehicle's run-log entries. `take_finished` gives each closed segment once."""

    def __init__(self, runs: Path, profile: bytes, road_map_json: bytes) -> None:
        """runs: the folder that holds one folder a boot."""
        self._runs = runs
        self._profile = profile
        self._road_map = zstandard.compress(road_map_json, 3)
        self._writer: SegmentWriter | None = None
        self._segment = -1
        self._finished: list[FinishedSegment] = []

    def write(self, entries: list[RunLogEntry]) -> None:
        """Raises FileExistsError when the boot_id is not new."""
        for entry in entries:
            if isinstance(entry, SegmentBegin):
                self.close()
                path = self._runs / entry.header.boot_id / f"{entry.header.segment:04d}.mcap"
                self._writer = SegmentWriter(path, entry.header, entry.state, self._profile, self._road_map)
                self._segment = entry.header.segment
            elif self._writer is not None:
                self._writer.add(entry.topic, entry.stamp_ns, entry.data)

    def close(self) -> None:
        """Finish the open segment."""
        if self._writer is not None:
            self._writer.close()
            self._finished.append(finished_segment(self._writer.path, self._segment))
            self._writer = None

    def take_finished(self) -> list[FinishedSegment]:
        finished, self._finished = self._finished, []
        return finished


def finished_segment(path: Path, segment: int) -> FinishedSegment:
    data = path.read_bytes()
    return FinishedSegment(str(path), hashlib.sha256(data).hexdigest(), len(data), segment)
