"""What a run records. A run is one vehicle and one boot, in segments that can each be read alone.

Every segment begins with a header and the complete onboard state, so that any of them can be replayed
without the ones before; then one record a tick: everything that entered, and what each room made of it.
"""

import hashlib
from collections.abc import Iterable
from typing import Literal

import msgspec

# 2: the signals have the field's names (docs/glossary.md); states and inputs of version 1 use others.
RUNLOG_VERSION = 2

TICK_TOPIC = "/tick"
REPORT_TOPIC = "/report"
EVENT_TOPIC = "/event"
TRANSFORM_TOPIC = "/tf"
POSE_TOPIC = "/ego/pose"
LOCATION_TOPIC = "/ego/location"
OBSTACLE_TOPIC = "/perception/obstacles"
POINTS_TOPIC = "/perception/points"
SCENE_TOPIC = "/scene"
MAP_TOPIC = "/map"
MARK_TOPIC = "/mark"
ONBOARD_TOPIC = "/onboard"
SCAN_TOPIC = "/localization/scan"

STATE_ATTACHMENT = "onboard_state.msgpack"
MAP_ATTACHMENT = "road_map.json.zst"
PROFILE_ATTACHMENT = "profile.msgpack"
HEADER_METADATA = "campusloop.run"


NO_LOCALIZATION_MAP = "none"


class RunHeader(msgspec.Struct, frozen=True):
    """first_tick is the tick that the segment's first record holds; the attached state is the one before it.

    utc_offset_ns   UTC minus the vehicle's monotonic clock, as known when the segment began; log times are
                    stamp_ns + utc_offset_ns
    head_sha256     over the attachments; the writer fills it in
    localization_map  version of the map that scans were compared with; `NO_LOCALIZATION_MAP` of a vehicle
                    that waits for its map, "" of one that compares no scans
    """

    vehicle_id: str
    boot_id: str
    segment: int
    campus_id: str
    map_version: str
    stack: str
    software: str
    utc_offset_ns: int
    first_tick: int
    version: int = RUNLOG_VERSION
    head_sha256: str = ""
    localization_map: str = ""


def head_digest(attachments: Iterable[bytes]) -> str:
    """Of state, profile and map, in this order: MCAP readers do not check attachments by themselves."""
    digest = hashlib.sha256()
    for attachment in attachments:
        digest.update(attachment)
    return digest.hexdigest()


class TickRecord(msgspec.Struct, frozen=True):
    """One tick. `items` is the input tape, `rooms` what each room gave, by name, in flow order.

    Both are MessagePack of the vehicle's own signals (vehicle_agent.signals); here they pass unread.
    """

    tick: int
    stamp_ns: int
    late_ns: int
    items: msgspec.Raw
    rooms: msgspec.Raw


class LogTime(msgspec.Struct, frozen=True):
    sec: int
    nsec: int


MarkKind = Literal["mark", "start_recording", "stop_recording"]


class RecordingMark(msgspec.Struct, frozen=True):
    """An operator's mark in the run, or where a named recording begins or ends.

    With the fields of Foxglove's `Log`, so that viewers list it, and our own.

    timestamp  UTC of the marked moment: when the operator gave the command. It may have reached the vehicle
               later; the log time of the message says when
    message    the operator's note, or the recording's name
    name       "mark", "start_recording" or "stop_recording"
    mark_id    the command's id on the server
    """

    timestamp: LogTime
    message: str
    name: MarkKind
    mark_id: str
    level: int = 2
    file: str = ""
    line: int = 0

    @property
    def at_ns(self) -> int:
        """UTC nanoseconds."""
        return self.timestamp.sec * 1_000_000_000 + self.timestamp.nsec


def recording_mark(at_ns: int, note: str, kind: MarkKind, mark_id: str) -> RecordingMark:
    return RecordingMark(LogTime(*divmod(at_ns, 1_000_000_000)), note, kind, mark_id)
