"""What one vehicle sees and plans in detail, on request: what the status and its driving view leave out."""

from typing import Annotated

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import Coordinate, Count, Distance, Duration, ShortText, Speed, StampNs
from contract.wire.reasons import SpeedLimitReason

# Of one scene: 600 points and the graph of a busy crossing take 15 kB of JSON.
SCENE_POINTS_MAX = 600
KNOTS_MAX = 200
PATH_TRACKS_MAX = 100
LIMITS_MAX = 100
ROOMS_MAX = 50


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


class OnboardScene(Message, frozen=True, tag="onboard_scene"):
    """What a vehicle sees and plans. Path, tracks and areas are in the status of the same moment.

    points        x0, y0, x1, y1, ... obstacle cells, map frame, the nearest; points_age_s since their scan
    guard         what the guard does against the plan, "" for nothing
    path_times    None of a stack that plans no times
    tick_times    None where ticks are not timed, as in virtual time
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
