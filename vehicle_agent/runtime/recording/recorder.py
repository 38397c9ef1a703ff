"""A tick's entries for the run log: the input tape, each room's output, and channels for viewers.

The recorder only makes entries; `runlog_files` writes them. Arrays are recorded as digests, since a replay
computes them again from the tape.
"""

import hashlib
import math
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np

from contract.roads.model import ObservationArea
from contract.runlog import foxglove
from contract.runlog.arrays import enc_hook
from contract.runlog.matched_scans import MatchedScan
from contract.runlog.records import (
    EVENT_TOPIC,
    LOCATION_TOPIC,
    MARK_TOPIC,
    OBSTACLE_TOPIC,
    ONBOARD_TOPIC,
    POINTS_TOPIC,
    POSE_TOPIC,
    REPORT_TOPIC,
    SCAN_TOPIC,
    SCENE_TOPIC,
    TICK_TOPIC,
    TRANSFORM_TOPIC,
    MarkKind,
    RunHeader,
    TickRecord,
    recording_mark,
)
from contract.wire.codec import encode
from contract.wire.messages import Command, CommandDone, OnboardScene, TracksBy
from vehicle_agent.config import Body
from vehicle_agent.onboard.driving_view import report_with_driving_view
from vehicle_agent.onboard.seen_things import PlacedScan
from vehicle_agent.onboard.state import OnboardState
from vehicle_agent.runtime.recording.snapshot import encode_state
from vehicle_agent.runtime.recording.viewer_scene import ViewerScene
from vehicle_agent.signals import Detections, Flow, ForViewers, GnssFix, InboxItem, Outputs
from vehicle_agent.signals.rates import REPORT_EVERY_TICKS, TRANSFORM_EVERY_TICKS

SEGMENT_TICKS = 5 * 60 * 50
# The detail of a tick, made only where it is recorded.
MakeScene = Callable[[Outputs, int], OnboardScene]
SIGNALS = (*Flow.__struct_fields__, "frames", "events", "answers")


class SegmentBegin(msgspec.Struct, frozen=True, tag="segment_begin"):
    """Ends the segment before, if any, and begins another with this header."""

    header: RunHeader
    state: bytes


class LogEntry(msgspec.Struct, frozen=True, tag="log_entry"):
    topic: str
    stamp_ns: int
    data: bytes


RunLogEntry = SegmentBegin | LogEntry


class FlowEncoder:
    """Encodes a tick's signals as MessagePack, room by room; an unchanged object is encoded once."""

    def __init__(self) -> None:
        self._cache: dict[str, tuple[object, msgspec.Raw]] = {}
        self._encoder = msgspec.msgpack.Encoder(enc_hook=_array_digest)

    def encode(self, outputs: Outputs) -> msgspec.Raw:
        flow = outputs.flow
        rooms = {name: self._room(name, getattr(flow, name)) for name in flow.__struct_fields__}
        rooms["frames"] = msgspec.Raw(self._encoder.encode(outputs.frames))
        rooms["events"] = msgspec.Raw(self._encoder.encode(outputs.events))
        rooms["answers"] = msgspec.Raw(self._encoder.encode(outputs.answers))
        return msgspec.Raw(self._encoder.encode(rooms))

    def _room(self, name: str, signal: Any) -> msgspec.Raw:
        cached = self._cache.get(name)
        if cached is not None and cached[0] is signal:
            return cached[1]
        plain = msgspec.structs.replace(signal, line=None) if name == "task" else signal
        encoded = msgspec.Raw(self._encoder.encode(plain))
        self._cache[name] = (signal, encoded)
        return encoded


def _array_digest(value: object) -> object:
    if isinstance(value, np.ndarray):
        digest = hashlib.blake2b(np.ascontiguousarray(value).data, digest_size=8)
        return (f"{value.dtype.str}{value.shape}", digest.digest())
    raise NotImplementedError(f"{type(value)} in a signal")


class Recorder:
    """Turns ticks into run-log entries, and begins a segment every five minutes.

    Also where an operator's recording begins and ends.
    """

    def __init__(
        self,
        header: RunHeader,
        body: Body,
        areas: tuple[ObservationArea, ...] = (),
        tracks_by: TracksBy = "",
    ) -> None:
        """header: of the first segment, whose counters are set here; areas: of the map.

        tracks_by  who finds road users, for viewers (`Profile.perception`)
        """
        self._header = header
        self._scene = ViewerScene(header.vehicle_id, body, areas, tracks_by)
        self._flow = FlowEncoder()
        self._items = msgspec.msgpack.Encoder(enc_hook=enc_hook)
        self._records = msgspec.msgpack.Encoder()
        self._ticks = 0
        self._segment = -1
        self._segment_begins_at = 0
        self._last_detections: Detections | None = None

    def record(
        self,
        before: OnboardState,
        items: Sequence[InboxItem],
        outputs: Outputs,
        stamp_ns: int,
        late_ns: int,
        utc_offset_ns: int,
        scene: MakeScene,
        scan: PlacedScan | None = None,
    ) -> list[RunLogEntry]:
        """The entries of the tick that took `before` and `items` and gave `outputs`.

        scan  that came in this tick, for viewers
        """
        entries: list[RunLogEntry] = []
        commands = _recording_commands(items, outputs)
        kinds = [kind for kind, _ in commands]
        if "start_recording" in kinds or self._ticks >= self._segment_begins_at:
            entries.append(self._begin_segment(before, utc_offset_ns))
        record = TickRecord(
            before.tick,
            stamp_ns,
            late_ns,
            # No room reads these: a replay needs them as little as the rooms do.
            msgspec.Raw(self._items.encode([one for one in items if not isinstance(one.body, ForViewers)])),
            self._flow.encode(outputs),
        )
        entries.append(LogEntry(TICK_TOPIC, stamp_ns, self._records.encode(record)))
        entries += [_mark(*one, stamp_ns, utc_offset_ns) for one in commands]
        entries += self._channels(items, outputs, stamp_ns, utc_offset_ns)
        if scan is not None:
            cloud = foxglove.scan_cloud(scan.stamp_ns + utc_offset_ns, scan.pose_map, scan.points_base)
            entries.append(LogEntry(POINTS_TOPIC, stamp_ns, cloud))
        if self._ticks % REPORT_EVERY_TICKS == 0:
            entries.append(LogEntry(ONBOARD_TOPIC, stamp_ns, encode(scene(outputs, stamp_ns))))
        self._ticks += 1
        if "stop_recording" in kinds:
            self.begin_segment()
        return entries

    def begin_segment(self) -> None:
        """The next tick begins a segment.

        A recording that an operator asked for has ended, or entries of this segment were lost, and no replay
        gets past them.
        """
        self._segment_begins_at = self._ticks

    def _begin_segment(self, before: OnboardState, utc_offset_ns: int) -> SegmentBegin:
        self._segment += 1
        self._segment_begins_at = self._ticks + SEGMENT_TICKS
        self._last_detections = None
        header = msgspec.structs.replace(
            self._header, segment=self._segment, first_tick=before.tick, utc_offset_ns=utc_offset_ns
        )
        return SegmentBegin(header, encode_state(before))

    def _channels(
        self, items: Sequence[InboxItem], outputs: Outputs, stamp_ns: int, utc_offset_ns: int
    ) -> list[LogEntry]:
        """The entries for viewers, at 5 and 10 Hz."""
        flow, utc_ns = outputs.flow, stamp_ns + utc_offset_ns
        entries = [LogEntry(EVENT_TOPIC, stamp_ns, msgspec.json.encode(event)) for event in outputs.events]
        scans = [item.body for item in items if isinstance(item.body, MatchedScan)]
        entries += [LogEntry(SCAN_TOPIC, stamp_ns, msgspec.json.encode(scan)) for scan in scans]
        if self._ticks % REPORT_EVERY_TICKS == 0 or outputs.events:
            entries.append(LogEntry(REPORT_TOPIC, stamp_ns, encode(report_with_driving_view(outputs))))
        if self._ticks % REPORT_EVERY_TICKS == 0:
            entries.append(LogEntry(SCENE_TOPIC, stamp_ns, self._scene.scene(flow, utc_ns)))
        if self._ticks % TRANSFORM_EVERY_TICKS == 0:
            pose_map = flow.ego.pose_map
            transform = foxglove.frame_transform(utc_ns, pose_map)
            entries.append(LogEntry(TRANSFORM_TOPIC, stamp_ns, transform))
            entries.append(LogEntry(POSE_TOPIC, stamp_ns, foxglove.pose_in_frame(utc_ns, pose_map)))
            fixes = [item.body for item in items if isinstance(item.body, GnssFix)]
            entries += [LogEntry(LOCATION_TOPIC, stamp_ns, _location(utc_ns, fix)) for fix in fixes[-1:]]
        if flow.detections is not self._last_detections:
            self._last_detections = flow.detections
            entries.append(
                LogEntry(OBSTACLE_TOPIC, stamp_ns, foxglove.point_cloud(utc_ns, flow.detections.points_map))
            )
        return entries


def _recording_commands(items: Sequence[InboxItem], outputs: Outputs) -> list[tuple[MarkKind, Command]]:
    """The commands to the recording that this very tick has executed; repeats are not among them."""
    executed = {event.command_id for event in outputs.events if isinstance(event, CommandDone) and event.done}
    found: list[tuple[MarkKind, Command]] = []
    for item in items:
        match item.body:
            case Command(kind="mark" | "start_recording" | "stop_recording" as kind) as command:
                if command.command_id in executed:
                    found.append((kind, command))
    return found


def _mark(kind: MarkKind, command: Command, stamp_ns: int, utc_offset_ns: int) -> LogEntry:
    at_ns = command.made_ns or stamp_ns + utc_offset_ns
    mark = recording_mark(at_ns, command.text, kind, command.command_id)
    return LogEntry(MARK_TOPIC, stamp_ns, msgspec.json.encode(mark))


def _location(utc_ns: int, fix: GnssFix) -> bytes:
    std_m = fix.position_std_m if math.isfinite(fix.position_std_m) else 1e3
    return foxglove.location_fix(utc_ns, fix.latitude_deg, fix.longitude_deg, std_m)
