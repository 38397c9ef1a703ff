"""Where a vehicle is, what it does and what it sees; and where the others of the fleet are."""

from typing import Literal

import msgspec

from contract.geometry import Pose2
from contract.wire.base import Message
from contract.wire.reasons import FaultCode, FaultSeverity, HoldReason, SpeedLimitReason

DriveMode = Literal["autonomous", "held", "manual", "minimal_risk", "fault"]


class FaultReport(msgspec.Struct, frozen=True):
    code: FaultCode
    severity: FaultSeverity
    since_ns: int


class TrackReport(msgspec.Struct, frozen=True, array_like=True):
    """A tracked person, vehicle or other object, as the vehicle sees it; map frame, metres.

    kind        "pedestrian", "cyclist", "vehicle" or "other"
    yielded_to  the vehicle slows or stops for it
    ahead       where it is expected: x and y after 1, 2, 3 ... seconds; empty for what stands still
    """

    track_id: int
    kind: str
    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float
    yielded_to: bool = False
    ahead: tuple[float, ...] = ()


class AreaReport(msgspec.Struct, frozen=True):
    """An observation area that the vehicle watches.

    track_count   how many of its own tracks are in the area or about to enter it
    camera_count  how many people an infrastructure camera counts there, -1 without a report
    camera_age_s  age of that report
    """

    area_id: str
    track_count: int = 0
    camera_count: int = -1
    camera_age_s: float = 0.0


class DrivingView(msgspec.Struct, frozen=True):
    """What the vehicle sees and plans, for screens only. No decision uses it; the run log alone stores it.

    limited_by  what keeps the vehicle from going faster; a section that is not granted is in `waiting_for`
    path        x0, y0, x1, y1, ... of the rear axle's planned way, thinned
    tracks      the nearest ones
    """

    limited_by: SpeedLimitReason | None = None
    path: tuple[float, ...] = ()
    tracks: tuple[TrackReport, ...] = ()
    areas: tuple[AreaReport, ...] = ()


class Status(Message, frozen=True, tag="status"):
    """Where the vehicle is and what it does; latest wins.

    hold_reason, hold_detail  why the vehicle does not drive by itself, None when it does; detail: the
                              operator's own text, or which visit is unreachable
    """

    epoch: int
    stamp_ns: int
    pose_map: Pose2
    speed_mps: float
    accel_mps2: float
    steer_rad: float
    mode: DriveMode
    battery_ratio: float
    doors_open: bool
    lane_id: str
    s_m: float
    order_id: str
    revision: int
    visit_id: str
    aboard: tuple[str, ...] = ()
    screen: str = ""
    spoken: str = ""
    obstacle_m: float | None = None
    waiting_for: str = ""
    faults: tuple[FaultReport, ...] = ()
    driving: DrivingView | None = None
    hold_reason: HoldReason | None = None
    hold_detail: str = ""


class FleetVehicle(Message, frozen=True, tag="fleet_vehicle"):
    """Where another vehicle of the fleet is. Neither acknowledged nor repeated; the next status replaces it.

    server_ns: when the server received that vehicle's status
    """

    epoch: int
    vehicle_id: str
    server_ns: int
    pose_map: Pose2
    speed_mps: float
