"""Where a vehicle is, what it does and what it sees; and where the others of the fleet are."""

from typing import Annotated, Literal

import msgspec

from contract.geometry import Pose2
from contract.wire.base import Message
from contract.wire.bounds import (
    SEATS_MAX,
    Acceleration,
    Angle,
    ArcLength,
    BodyLength,
    Coordinate,
    Count,
    Distance,
    Duration,
    Id,
    LongText,
    PeopleCount,
    PlaceId,
    Ratio,
    ShortText,
    Speed,
    StampNs,
)
from contract.wire.reasons import FaultCode, FaultSeverity, HoldReason, LocalizationPhase, SpeedLimitReason

POINTS_MAX = 20_000
TRACKS_MAX = 2_000
FAULTS_MAX = 200

DriveMode = Literal["autonomous", "held", "manual", "minimal_risk", "fault"]
TurnSignal = Literal["right", "none", "left", "hazard"]
Headlights = Literal["off", "low", "high"]


class FaultReport(msgspec.Struct, frozen=True):
    """A fault. detail: which device it is about, by the vehicle's own names; "" where the code says it."""

    code: FaultCode
    severity: FaultSeverity
    since_ns: StampNs
    detail: ShortText = ""


class TrackReport(msgspec.Struct, frozen=True, array_like=True):
    """A tracked person, vehicle or other object, as the vehicle sees it; map frame, metres.

    kind        "pedestrian", "cyclist", "vehicle" or "other"
    yielded_to  the vehicle slows or stops for it
    ahead       where it is expected: x and y after 1, 2, 3 ... seconds; empty for what stands still
    """

    track_id: StampNs
    kind: ShortText
    x_m: Coordinate
    y_m: Coordinate
    yaw_rad: Angle
    length_m: BodyLength
    width_m: BodyLength
    yielded_to: bool = False
    ahead: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=POINTS_MAX)] = ()


class AreaReport(msgspec.Struct, frozen=True):
    """An observation area that the vehicle watches.

    track_count   how many of its own tracks are in the area or about to enter it
    camera_count  how many people an infrastructure camera counts there, -1 without a report
    camera_age_s  age of that report
    """

    area_id: PlaceId
    track_count: PeopleCount = 0
    camera_count: PeopleCount = -1
    camera_age_s: Duration = 0.0


class DrivingView(msgspec.Struct, frozen=True):
    """What the vehicle sees and plans, for screens only. No decision uses it; the run log alone stores it.

    limited_by  what keeps the vehicle from going faster; a section that is not granted is in `waiting_for`
    path        x0, y0, x1, y1, ... of the rear axle's planned way, thinned
    tracks      the nearest ones
    guard       what the guard does against the plan, "" for nothing
    turn_signal, headlights, horn  as the by-wire module reports them; None where it has none
    """

    limited_by: SpeedLimitReason | None = None
    path: Annotated[tuple[Coordinate, ...], msgspec.Meta(max_length=POINTS_MAX)] = ()
    tracks: Annotated[tuple[TrackReport, ...], msgspec.Meta(max_length=TRACKS_MAX)] = ()
    areas: Annotated[tuple[AreaReport, ...], msgspec.Meta(max_length=TRACKS_MAX)] = ()
    turn_signal: TurnSignal | None = None
    headlights: Headlights | None = None
    horn: bool | None = None
    guard: ShortText = ""


class LocalizationReport(msgspec.Struct, frozen=True):
    """How well the vehicle knows where it is.

    phase           "gnss_only" also of a vehicle that compares no scans with a map
    position_std_m  standard deviation along its worst direction; None while there is no position
    agreement       share of the last scan's points that lie on the map; None without one
    """

    phase: LocalizationPhase
    position_std_m: Distance | None = None
    agreement: Ratio | None = None


class Status(Message, frozen=True, tag="status"):
    """Where the vehicle is and what it does; latest wins.

    hold_reason, hold_detail  why the vehicle does not drive by itself, None when it does; detail: the
                              operator's own text, or which visit is unreachable
    """

    epoch: Count
    stamp_ns: StampNs
    pose_map: Pose2
    speed_mps: Speed
    accel_mps2: Acceleration
    steer_rad: Angle
    mode: DriveMode
    battery_ratio: Ratio
    doors_open: bool
    lane_id: PlaceId
    s_m: ArcLength
    order_id: Id
    revision: Count
    visit_id: Id
    aboard: Annotated[tuple[Id, ...], msgspec.Meta(max_length=SEATS_MAX)] = ()
    screen: LongText = ""
    spoken: LongText = ""
    obstacle_m: Distance | None = None
    waiting_for: PlaceId = ""
    faults: Annotated[tuple[FaultReport, ...], msgspec.Meta(max_length=FAULTS_MAX)] = ()
    driving: DrivingView | None = None
    hold_reason: HoldReason | None = None
    hold_detail: LongText = ""
    localization: LocalizationReport | None = None


class FleetVehicle(Message, frozen=True, tag="fleet_vehicle"):
    """Where another vehicle of the fleet is. Neither acknowledged nor repeated; the next status replaces it.

    server_ns: when the server received that vehicle's status
    """

    epoch: Count
    vehicle_id: Id
    server_ns: StampNs
    pose_map: Pose2
    speed_mps: Speed
