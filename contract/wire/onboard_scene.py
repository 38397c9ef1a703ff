"""What one vehicle sees and plans in detail, on request: what the status and its driving view leave out."""

from typing import Annotated, Literal

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import (
    Angle,
    BodyLength,
    Coordinate,
    Count,
    Distance,
    Duration,
    ShortText,
    Speed,
    StampNs,
)
from contract.wire.reasons import SpeedLimitReason

SCENE_POINTS_MAX = 600
SCENE_TRACKS_MAX = 100
SCENE_SIGNS_MAX = 100
SCAN_POINTS_MAX = 2_000
KNOTS_MAX = 200
PATH_TRACKS_MAX = 100
LIMITS_MAX = 100
ROOMS_MAX = 50

# Road users are found by the vehicle in its own scans, or by another computer; "": it has cells only.
TracksBy = Literal["", "own", "tracker"]
# "board": a sign whose shape is not known yet; "other": neither stop nor yield.
SignKind = Literal["stop", "yield", "board", "other"]


class LimitAhead(msgspec.Struct, frozen=True, array_like=True):
    """A speed limit on a stretch of the planned path, ways from the start of the plan."""

    from_m: Distance
    to_m: Distance
    speed_mps: Speed
    reason: SpeedLimitReason


class PathTrack(msgspec.Struct, frozen=True, array_like=True):
    """When and where a track is on the planned path.

    knots         the knots at which it is
    from_m, to_m  the stretch that it occupies at each of them, by the rear axle's way
    """

    track_id: StampNs
    yielded_to: bool
    knots: Annotated[tuple[Count, ...], msgspec.Meta(max_length=KNOTS_MAX)]
    from_m: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=KNOTS_MAX)]
    to_m: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=KNOTS_MAX)]


class PathTimes(msgspec.Struct, frozen=True):
    """The s-t graph of the present plan: way along the path over time.

    age_s          since the moment at which the plan begins; negative: it begins later
    dt_s           between knots
    way_m          of the rear axle by knot: the motion that was chosen
    low_m, high_m  the corridor that people and obstacles leave, by knot; None: nothing bounds it there
    limits         by place, nearest first
    """

    age_s: Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]
    dt_s: Duration
    way_m: Annotated[tuple[Distance, ...], msgspec.Meta(max_length=KNOTS_MAX)]
    low_m: Annotated[tuple[Distance | None, ...], msgspec.Meta(max_length=KNOTS_MAX)]
    high_m: Annotated[tuple[Distance | None, ...], msgspec.Meta(max_length=KNOTS_MAX)]
    tracks: Annotated[tuple[PathTrack, ...], msgspec.Meta(max_length=PATH_TRACKS_MAX)] = ()
    limits: Annotated[tuple[LimitAhead, ...], msgspec.Meta(max_length=LIMITS_MAX)] = ()


class RoomTime(msgspec.Struct, frozen=True, array_like=True):
    room: ShortText
    time_us: Count


class TickTimes(msgspec.Struct, frozen=True):
    """The slowest tick since the last scene: each room's time, the whole, and how late it began."""

    rooms: Annotated[tuple[RoomTime, ...], msgspec.Meta(max_length=ROOMS_MAX)]
    whole_us: Count
    late_us: Count


class ShownTrack(msgspec.Struct, frozen=True, array_like=True):
    """A road user that the vehicle sees: as in `TrackReport`, with its velocity along the map's axes."""

    track_id: StampNs
    kind: ShortText
    x_m: Coordinate
    y_m: Coordinate
    yaw_rad: Angle
    length_m: BodyLength
    width_m: BodyLength
    velocity_x_mps: Speed
    velocity_y_mps: Speed
    yielded_to: bool = False


class ShownSign(msgspec.Struct, frozen=True, array_like=True):
    """A traffic sign that the vehicle sees.

    yaw_rad     of its face, towards those for whom it stands
    distance_m  from the rear axle's centre
    """

    sign_id: StampNs
    kind: SignKind
    x_m: Coordinate
    y_m: Coordinate
    yaw_rad: Angle
    distance_m: Distance


class ShownScan(msgspec.Struct, frozen=True):
    """Points of one lidar scan above the road, thinned.

    x_m, y_m    the place in the map from which offsets count; age_s: since the scan
    offsets_cm  int16, little-endian: x0, y0, z0, x1, ... along the map's axes; z from the ground under the
                rear axle
    """

    x_m: Coordinate
    y_m: Coordinate
    age_s: Duration
    offsets_cm: Annotated[bytes, msgspec.Meta(max_length=6 * SCAN_POINTS_MAX)]


class OnboardScene(Message, frozen=True, tag="onboard_scene"):
    """What a vehicle sees and plans. Path, predictions and areas are in the status of the same moment.

    points        x0, y0, x1, y1, ... obstacle cells, map frame, the nearest; points_age_s since their scan
    guard         what the guard does against the plan, "" for nothing
    path_times    None of a stack that plans no times
    tick_times    None where ticks are not timed, as in virtual time
    tracks_by     who finds road users; tracks: the nearest, tracks_age_s since the scan that shows them
    scan          the newest; None without one of the last seconds. In a recorded run it is with the first
                  scene after it
    """

    epoch: Count
    stamp_ns: StampNs
    points: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=2 * SCENE_POINTS_MAX)] = ()
    points_age_s: Duration = 0.0
    limited_by: SpeedLimitReason | None = None
    speed_mps_planned: Speed = 0.0
    guard: ShortText = ""
    path_times: PathTimes | None = None
    tick_times: TickTimes | None = None
    tracks_by: TracksBy = ""
    tracks: Annotated[tuple[ShownTrack, ...], msgspec.Meta(max_length=SCENE_TRACKS_MAX)] = ()
    tracks_age_s: Duration = 0.0
    signs: Annotated[tuple[ShownSign, ...], msgspec.Meta(max_length=SCENE_SIGNS_MAX)] = ()
    scan: ShownScan | None = None
