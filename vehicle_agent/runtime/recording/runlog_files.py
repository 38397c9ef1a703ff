"""A vehicle's runs on disk: one folder a boot, with its segments."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import msgspec
import zstandard

from contract.roads.load import decode_map
from contract.runlog.foxglove_map import MapScene
from contract.runlog.records import MAP_TOPIC, RunHeader
from contract.runlog.writer import SegmentWriter
from vehicle_agent.runtime.recording.recorder import RunLogEntry, SegmentBegin


class FinishedSegment(msgspec.Struct, frozen=True):
    """A closed segment, ready for upload by its content's hash."""

    path: str
    sha256: str
    size_bytes: int
    segment: int


class RunLogFiles:
    """Writes a vehicle's run-log entries. `take_finished` gives each closed segment once."""

    def __init__(
        self, runs: Path, profile: bytes, road_map_json: bytes, read_map: Callable[[], bytes] | None = None
    ) -> None:
        """runs: the folder with one folder a boot.

        read_map: the map by which the vehicle drives now; None for a vehicle whose map never changes
        """
        self._runs = runs
        self._profile = profile
        self._read_map = read_map
        self._map_version = ""
        self._set_map(road_map_json)
        self._writer: SegmentWriter | None = None
        self._segment = -1
        self._pending_header: RunHeader | None = None
        self._finished: list[FinishedSegment] = []

    def write(self, entries: list[RunLogEntry]) -> None:
        """Writes entries. Raises OSError, e.g. for a full disk, and for a segment that exists already.

        Then call `give_up`.
        """
        for entry in entries:
            if isinstance(entry, SegmentBegin):
                self.close()
                self._follow_map(entry.header)
                path = self._runs / entry.header.boot_id / f"{entry.header.segment:04d}.mcap"
                self._writer = SegmentWriter(path, entry.header, entry.state, self._profile, self._road_map)
                self._segment, self._pending_header = entry.header.segment, entry.header
            elif self._writer is not None:
                if self._pending_header is not None:
                    self._add_map(self._writer, self._pending_header, entry.stamp_ns)
                    self._pending_header = None
                self._writer.add(entry.topic, entry.stamp_ns, entry.data)

    def _set_map(self, road_map_json: bytes) -> None:
        self._road_map_json = road_map_json
        self._road_map = zstandard.compress(road_map_json, 3)
        self._map_scene: MapScene | None = None

    def _follow_map(self, header: RunHeader) -> None:
        """A segment has the map of its run. Raises OSError."""
        if self._map_version not in ("", header.map_version) and self._read_map is not None:
            self._set_map(self._read_map())
        self._map_version = header.map_version

    def _add_map(self, writer: SegmentWriter, header: RunHeader, stamp_ns: int) -> None:
        """Writes the map's scene, before the segment's first message."""
        if self._map_scene is None:
            self._map_scene = MapScene(decode_map(self._road_map_json))
        writer.add(MAP_TOPIC, stamp_ns, self._map_scene.at(stamp_ns + header.utc_offset_ns))

    def give_up(self) -> None:
        """Leaves the open segment as far as it is on the disk; writes nothing until the next one begins."""
        if self._writer is not None:
            self._writer.abandon()
            self._writer = None

    def close(self) -> None:
        """Finishes the open segment. Raises OSError."""
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
