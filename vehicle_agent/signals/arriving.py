"""What comes in from devices, workers, riders, the link and infrastructure."""

from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Pose2


class CanFrame(msgspec.Struct, frozen=True, tag="can_frame"):
    """One classic CAN frame as received or to be sent."""

    stamp_ns: int
    arbitration_id: int
    data: bytes


class GnssFix(msgspec.Struct, frozen=True, tag="gnss_fix"):
    """A GNSS/INS solution of the antenna frame, already moved to the rear-axle centre by the driver.

    heading_rad is a REP-103 yaw: counter-clockwise from east. position_std_m and heading_std_rad are the
    receiver's own statements; 0.0: it states none for its heading.
    """

    stamp_ns: int
    latitude_deg: float
    longitude_deg: float
    heading_rad: float
    speed_mps: float
    yaw_rate_radps: float
    position_std_m: float
    heading_std_rad: float = 0.0


class ImuSample(msgspec.Struct, frozen=True, tag="imu_sample"):
    stamp_ns: int
    accel_mps2: float
    yaw_rate_radps: float


class ScanPose(msgspec.Struct, frozen=True, tag="scan_pose"):
    """Where a lidar scan lies on the map of surfaces, from a worker.

    stamp_ns     of the scan, whose points are straightened to it
    pose_map     of the rear axle's centre
    covariance   (3, 3) of x, y, yaw: large along what the surroundings do not show
    agreement    share of the points above the road that lie on the map, 0..1; points_up: how many there are
    is_searched  found by a search around a pose that was lost
    through      share of the beams above the road that would have gone through the map's walls, 0..1
    """

    stamp_ns: int
    pose_map: Pose2
    covariance: np.ndarray
    agreement: float
    points_up: int
    is_searched: bool = False
    through: float = 0.0


class ScanUnplaced(msgspec.Struct, frozen=True, tag="scan_unplaced"):
    """A lidar scan that says nothing of the vehicle's place, from a worker.

    reason  "no_map": the map has nothing around the vehicle; "too_little": the scan shows too little;
            "searching": the worker looks for the place on the map
    """

    stamp_ns: int
    reason: Literal["no_map", "too_little", "searching"]


class ObstaclePercept(msgspec.Struct, frozen=True, tag="obstacle_percept"):
    """The obstacle cells of one lidar scan, from a worker.

    stamp_ns     end of the scan
    cells_base   (n, 2) centres of occupied height-map cells, base frame at stamp_ns
    heights_m    (n,) height difference inside each cell
    points_used  returns that entered the map; 0 means the sensor is blind
    is_low       (n,) bool: kerbs, low steps with nothing above them; empty where nothing is known of it
    kerbs_base   (k, 2) kerbs of a finder that does not take them for obstacles; none is among the cells
    """

    stamp_ns: int
    cells_base: np.ndarray
    heights_m: np.ndarray
    points_used: int
    is_low: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.bool_))
    kerbs_base: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 2)))


class LidarCondition(msgspec.Struct, frozen=True):
    """What is wrong with one lidar, from its driver.

    name         as in the vehicle's `sensors.toml`
    state        "silent": no packets; "unusable": turns that cannot be used; "moved": the road says that it
                 is not where it was calibrated, while its points are used all the same
    is_required  without it the vehicle is blind
    """

    name: str
    state: Literal["silent", "unusable", "moved"]
    is_required: bool = True


class LidarConditions(msgspec.Struct, frozen=True, tag="lidar_conditions"):
    """All lidars with which something is wrong, once a second and when it changes; none: all are well."""

    stamp_ns: int
    lidars: tuple[LidarCondition, ...] = ()


class TrackPercept(msgspec.Struct, frozen=True, tag="track_percept"):
    """The tracked road users of one scan, from a tracker.

    stamp_ns             end of the scan
    ids (n,), kinds (n,) int64: constant as long as a road user is tracked; index into TRACK_KINDS
    poses_base (n, 3)    x, y, yaw of the middle of its outline, base frame at stamp_ns
    velocities_base_mps  (n, 2) over ground, along the axes of that base frame
    sizes_m (n, 2)       length and width; a person is a disc of that diameter
    """

    stamp_ns: int
    ids: np.ndarray
    kinds: np.ndarray
    poses_base: np.ndarray
    velocities_base_mps: np.ndarray
    sizes_m: np.ndarray


class SignPercept(msgspec.Struct, frozen=True, tag="sign_percept"):
    """The retro-reflective boards of one scan, from a worker: which signs they are is told over scans.

    stamp_ns     end of the scan
    boards_base  (n, 6) x, y of the board's axis, z of the middle of what was seen, yaw of the normal towards
                 the vehicle, base frame at stamp_ns; height of the lowest return above the ground around;
                 number of returns
    chords       (k, 5) in which the rings cut the boards: width, heights of the left and of the right end,
                 standard deviation of the width, how far the chord's middle is to the right of the axis
    owners       (k,) int64: the board of each chord
    """

    stamp_ns: int
    boards_base: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 6)))
    chords: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 5)))
    owners: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.int64))


class ThinnedScan(msgspec.Struct, frozen=True, tag="thinned_scan"):
    """Some points of one lidar scan above the road, for people who look. No room reads it.

    stamp_ns   end of the scan
    points_cm  int16, little-endian: x0, y0, z0, x1, ... base frame at stamp_ns
    """

    stamp_ns: int
    points_cm: bytes


class SeatButton(msgspec.Struct, frozen=True, tag="seat_button"):
    """A passenger requests a stop before the planned one."""

    stamp_ns: int
    seat: int


class CodeTyped(msgspec.Struct, frozen=True, tag="code_typed"):
    """A rider typed a boarding code on the onboard screen."""

    stamp_ns: int
    code: str


class HelpButton(msgspec.Struct, frozen=True, tag="help_button"):
    """A passenger calls for help. seat: 0 if it is not known."""

    stamp_ns: int
    seat: int = 0


class DestinationChoice(msgspec.Struct, frozen=True, tag="destination_choice"):
    """A party aboard chose another stop on the onboard screen. code: its boarding code, "" without one."""

    stamp_ns: int
    code: str
    stop_id: str


class SeatSensor(msgspec.Struct, frozen=True, tag="seat_sensor"):
    """The number of occupied seats, by the seat mats."""

    stamp_ns: int
    occupied: int


class DoorState(msgspec.Struct, frozen=True, tag="door_state"):
    stamp_ns: int
    open: bool


class LinkState(msgspec.Struct, frozen=True, tag="link_state"):
    """From the link process: the session, and server clock minus vehicle clock."""

    stamp_ns: int
    connected: bool
    epoch: int
    server_offset_ns: int


class FleetVehicle(msgspec.Struct, frozen=True, tag="fleet_vehicle"):
    """A fleet vehicle's pose, from infrastructure or the server; stamped in this vehicle's clock."""

    stamp_ns: int
    vehicle_id: str
    pose_map: Pose2
    speed_mps: float


class PedestrianPresence(msgspec.Struct, frozen=True, tag="pedestrian_presence"):
    """NUS: an infrastructure camera's count of people in an observation area.

    by_server  the server has checked who says so; a datagram of the vehicle's network may be anybody's
    """

    stamp_ns: int
    area_id: str
    count: int
    by_server: bool = False


# Kinds of road users, by number.
TRACK_KINDS = ("pedestrian", "cyclist", "vehicle", "other")
PEDESTRIAN, CYCLIST, VEHICLE, OTHER = range(len(TRACK_KINDS))
