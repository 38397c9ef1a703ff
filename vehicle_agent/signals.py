"""Every value that passes a door onboard, in flow order.

Frames: `base` is the rear-axle centre (x forward, y left); `map` is the road map's frame. `stamp_ns` is the
vehicle's monotonic clock. Arrays are numpy, float64 unless stated; nobody writes into an array that has
passed a door.
"""

from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.roads.areas import AreaAhead
from contract.roads.routing import ReferenceLine
from contract.wire.messages import (
    Command,
    DriveMode,
    FaultReport,
    Grants,
    Order,
    OrderAccepted,
    OrderRejected,
    PassengerTap,
    Status,
    VehicleEvent,
)

# ---------------------------------------------------------------- what comes in


class CanFrame(msgspec.Struct, frozen=True, tag="can_frame"):
    """One classic CAN frame as received or to be sent."""

    stamp_ns: int
    arbitration_id: int
    data: bytes


class GnssFix(msgspec.Struct, frozen=True, tag="gnss_fix"):
    """A GNSS/INS solution of the antenna frame, already moved to the rear-axle centre by the driver.

    heading_rad is a REP-103 yaw: counter-clockwise from east.
    """

    stamp_ns: int
    latitude_deg: float
    longitude_deg: float
    heading_rad: float
    speed_mps: float
    yaw_rate_radps: float
    position_std_m: float


class ImuSample(msgspec.Struct, frozen=True, tag="imu_sample"):
    stamp_ns: int
    accel_mps2: float
    yaw_rate_radps: float


class ObstaclePercept(msgspec.Struct, frozen=True, tag="obstacle_percept"):
    """A worker's answer to one lidar scan: where something stands above the ground.

    stamp_ns     end of the scan
    cells_base   (n, 2) centres of occupied height-map cells, base frame at stamp_ns
    heights_m    (n,) height difference inside each cell
    points_used  returns that entered the map; 0 means the sensor is blind
    """

    stamp_ns: int
    cells_base: np.ndarray
    heights_m: np.ndarray
    points_used: int


class TrackPercept(msgspec.Struct, frozen=True, tag="track_percept"):
    """A tracker's answer to one scan: who and what moves around the vehicle.

    stamp_ns             end of the scan
    ids (n,), kinds (n,) int64: the same number as long as a thing is followed; index into TRACK_KINDS
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


class SeatButton(msgspec.Struct, frozen=True, tag="seat_button"):
    """A passenger wants to get off before the planned stop."""

    stamp_ns: int
    seat: int


class CodeTyped(msgspec.Struct, frozen=True, tag="code_typed"):
    """A rider typed a boarding code on the onboard screen."""

    stamp_ns: int
    code: str


class SeatSensor(msgspec.Struct, frozen=True, tag="seat_sensor"):
    """How many seats are taken now, by the seat mats."""

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


class PlanAnswer(msgspec.Struct, frozen=True, tag="plan_answer"):
    """The motion planner's answer to the job of the same number.

    stamp_ns     of the job: the vehicle clock at row 0 of the trajectory
    trajectory   (k, 8) see `Trajectory`; no rows when no motion at all could be planned
    limited_by   what keeps the vehicle from going faster; also for people to read
    cut_s_m      the line is blocked for good from here on (the paper's pi_s); inf when it is not
    yields_to    ids of the tracks that it slows or stops for
    violations   what the independent check found wrong, empty for a feasible trajectory
    memory       handed back with the next job
    """

    number: int
    stamp_ns: int
    line_id: int
    trajectory: np.ndarray
    limited_by: str
    cut_s_m: float
    yields_to: np.ndarray
    violations: tuple[str, ...]
    memory: "PlanMemory"


class PlanMemory(msgspec.Struct, frozen=True):
    """What the planner wants to know again next time; (0,) and (0, 3) arrays when there is nothing.

    offset_m     the lateral offset chosen, and for how many plans in a row another one has been better
    path_s_m, path_l_m  (n,) and (n, 3) the last path: offset and its two derivatives along the line
    stopping_for areas that it stops before, so that going on needs more than stopping did
    """

    offset_m: float = 0.0
    better_offset_m: float = 0.0
    better_count: int = 0
    path_s_m: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0))
    path_l_m: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 3)))
    stopping_for: tuple[str, ...] = ()


class OtherVehicle(msgspec.Struct, frozen=True, tag="other_vehicle"):
    """A fleet mate's pose as told by infrastructure or the server; stamped in this vehicle's clock."""

    stamp_ns: int
    vehicle_id: str
    pose_map: Pose2
    speed_mps: float


class PedestrianPresence(msgspec.Struct, frozen=True, tag="pedestrian_presence"):
    """NUS: an infrastructure camera's word on whether a crossing is occupied."""

    stamp_ns: int
    area_id: str
    count: int


ServerWord = Order | Grants | Command | PassengerTap
Percept = ObstaclePercept | TrackPercept
# What the link brings the tick.
LinkWord = ServerWord | LinkState | OtherVehicle | PedestrianPresence
Pressed = SeatButton | CodeTyped | SeatSensor | DoorState
Infrastructure = OtherVehicle | PedestrianPresence
# What a track can be, by number.
TRACK_KINDS = ("pedestrian", "cyclist", "vehicle", "other")
PEDESTRIAN, CYCLIST, VEHICLE, OTHER = range(len(TRACK_KINDS))
InboxBody = (
    CanFrame
    | GnssFix
    | ImuSample
    | ObstaclePercept
    | TrackPercept
    | PlanAnswer
    | SeatButton
    | CodeTyped
    | SeatSensor
    | DoorState
    | LinkState
    | OtherVehicle
    | PedestrianPresence
    | Order
    | Grants
    | Command
    | PassengerTap
)


class InboxItem(msgspec.Struct, frozen=True):
    """Something that is not deterministic, at the moment it reached the vehicle computer."""

    arrival_ns: int
    source: str
    sequence: int
    body: InboxBody


class Inputs(msgspec.Struct, frozen=True):
    """One tick's drained inbox, sorted by (arrival_ns, source, sequence) and split by kind."""

    stamp_ns: int
    frames: tuple[CanFrame, ...] = ()
    poses: tuple[GnssFix | ImuSample, ...] = ()
    percepts: tuple[Percept, ...] = ()
    plans: tuple[PlanAnswer, ...] = ()
    infrastructure: tuple[Infrastructure, ...] = ()
    words: tuple[ServerWord, ...] = ()
    pressed: tuple[Pressed, ...] = ()
    link: LinkState | None = None


# ---------------------------------------------------------------- what flows between the rooms


class Fault(msgspec.Struct, frozen=True):
    """Something is not as it should be. `stop` faults end in a minimal-risk stop."""

    code: str
    severity: Literal["info", "warning", "stop"]
    since_ns: int


# The fault that stands for the gate's own braking: it lets go only when by-wire is asked for anew.
GATE_BRAKING = "gate_braking"


class VehicleMotion(msgspec.Struct, frozen=True):
    """can: what the drive-by-wire reports, in SI units.

    stamp_ns      arrival of the newest speed report (0 before the first)
    steer_rad     front-wheel angle of the bicycle model, left positive
    enabled       by-wire has the vehicle
    overridden    the safety driver has taken over since the last enable
    """

    stamp_ns: int
    speed_mps: float
    steer_rad: float
    throttle_ratio: float
    brake_ratio: float
    enabled: bool
    overridden: bool
    ready: bool
    battery_ratio: float
    faults: tuple[Fault, ...] = ()


class Ego(msgspec.Struct, frozen=True):
    """localization: the vehicle itself, at `stamp_ns` (this tick).

    valid is False until the first fix and when the solution is too old or too poor to drive by; `faults`
    says what is wrong with it.
    """

    stamp_ns: int
    pose_map: Pose2
    speed_mps: float
    accel_mps2: float
    yaw_rate_radps: float
    steer_rad: float
    position_std_m: float
    fix_stamp_ns: int
    valid: bool
    faults: tuple[Fault, ...] = ()


class Tracks(msgspec.Struct, frozen=True):
    """Who and what moves, map frame; fields as in `TrackPercept`. stamp_ns 0 before the first."""

    stamp_ns: int
    ids: np.ndarray
    kinds: np.ndarray
    poses_map: np.ndarray
    velocities_map_mps: np.ndarray
    sizes_m: np.ndarray


NO_TRACKS = Tracks(
    0,
    np.empty(0, np.int64),
    np.empty(0, np.int64),
    np.empty((0, 3)),
    np.empty((0, 2)),
    np.empty((0, 2)),
)


class Seen(msgspec.Struct, frozen=True):
    """perception: obstacles around the vehicle; the same object until the next scan.

    points_map  (n, 2) obstacle cell centres, map frame
    stamp_ns    end of the scan they come from, 0 before the first
    """

    stamp_ns: int
    points_map: np.ndarray
    blind: bool
    tracks: Tracks = NO_TRACKS


class LeadVehicle(msgspec.Struct, frozen=True):
    """The fleet mate ahead on our path, and the free road between its rear and our front bumper."""

    vehicle_id: str
    gap_m: float
    speed_mps: float


class Predictions(msgspec.Struct, frozen=True):
    """Where each of the world's tracks is expected to be, in the order of the tracks.

    times_s     (k,) after stamp_ns, from 0 on
    poses_map   (n, k, 3) middle of the outline
    sigmas_m    (n, k) standard deviation of the place, in any direction
    """

    stamp_ns: int
    times_s: np.ndarray
    poses_map: np.ndarray
    sigmas_m: np.ndarray


NO_PREDICTIONS = Predictions(0, np.zeros(1), np.empty((0, 1, 3)), np.empty((0, 1)))


class View(msgspec.Struct, frozen=True):
    """How far the vehicle can see: what is beyond may hold a person.

    pose_map   of the sensor
    ranges_m   (n,) free line of sight by bearing in the sensor's frame, from -pi in n equal steps
    """

    pose_map: Pose2
    ranges_m: np.ndarray


NO_VIEW = View(Pose2(0.0, 0.0, 0.0), np.empty(0))


class WatchedArea(msgspec.Struct, frozen=True):
    """Who is in, or about to come into, one of the map's observation areas.

    track_ids  of moving tracks whose expected way leads across our lanes through it
    told       an infrastructure camera says that it is taken: a reason to slow, never one to go
    """

    area_id: str
    track_ids: tuple[int, ...]
    told: bool = False


class World(msgspec.Struct, frozen=True):
    """world: what the vehicle must respect, besides its own task.

    points_map  (n, 2) obstacle cells that are neither the fleet mates nor the tracks themselves
    others      fleet mates heard of lately
    tracks      who and what moves; predictions in the same order
    watched     the observation areas near the vehicle
    taken_stops stop ids whose place somebody else stands on
    """

    stamp_ns: int
    seen_stamp_ns: int
    points_map: np.ndarray
    others: tuple[OtherVehicle, ...]
    presence: tuple[PedestrianPresence, ...]
    blind: bool
    tracks: Tracks = NO_TRACKS
    predictions: Predictions = NO_PREDICTIONS
    view: View = NO_VIEW
    watched: tuple[WatchedArea, ...] = ()
    taken_stops: tuple[str, ...] = ()


TaskMode = Literal["idle", "drive", "dwell", "hold"]


class Task(msgspec.Struct, frozen=True):
    """mission: where to drive to and where to stop, along one reference line.

    line          the remaining route; the same object until the order changes
    line_id       grows by one whenever `line` is another
    s_m           the rear axle's place on the line
    stop_s_m      where the rear axle must stand, at the latest: visit, hold point or temporary stop
    waiting_for   section whose grant is missing, when that is why stop_s_m is where it is
    resumed_ns    when an operator last let the vehicle go; older latched stops may be released, 0 before
    announcement  what an operator wants to be said, new when announced_ns grows
    refused_ns    when the seat button was last refused on the way, 0 before
    """

    mode: TaskMode
    line: ReferenceLine | None
    line_id: int
    s_m: float
    d_m: float
    stop_s_m: float
    lane_id: str
    lane_s_m: float
    order_id: str
    revision: int
    visit_id: str
    stop_name: str
    stop_name_en: str
    doors_open: bool
    aboard: tuple[str, ...]
    waiting_for: str
    reason: str
    resumed_ns: int = 0
    announcement: str = ""
    announced_ns: int = 0
    refused_ns: int = 0


class Trajectory(msgspec.Struct, frozen=True):
    """Where the rear-axle centre shall be when.

    stamp_ns  vehicle clock at row 0
    rows      (k, 8) t_s since stamp_ns, x_m, y_m, yaw_rad (map, continuous along the rows), curvature_1pm,
              speed_mps, accel_mps2, s_m along the task's line; times strictly rising
    """

    stamp_ns: int
    rows: np.ndarray


class Corridor(msgspec.Struct, frozen=True):
    """A window of the task's line at even steps, with what the map says beside it; all arrays (n, ...).

    s_m         along the task's line; points_map (n, 2), yaw_rad continuous, curvature_1pm
    limit_mps   the lane's speed limit
    left_m, right_m  from the line to where a body may no longer be (kerb, wall), both positive
    scenario    int64 index into contract.roads.model.SCENARIOS
    """

    s_m: np.ndarray
    points_map: np.ndarray
    yaw_rad: np.ndarray
    curvature_1pm: np.ndarray
    limit_mps: np.ndarray
    left_m: np.ndarray
    right_m: np.ndarray
    scenario: np.ndarray


class PlanJob(msgspec.Struct, frozen=True, tag="plan_job"):
    """Everything that one motion plan depends on: the planner itself remembers nothing.

    stamp_ns     vehicle clock at the start state, at which the trajectory shall begin
    pose_map, speed_mps, accel_mps2, curvature_1pm   the start state: where the vehicle is expected then
    stop_s_m     where the rear axle must stand at the latest
    speed_mps_max  the lowest of all limits that hold everywhere, and what it is for
    points_map   (m, 2) obstacle cells near the corridor
    areas        the line's passes through observation areas within the corridor
    """

    number: int
    stamp_ns: int
    line_id: int
    pose_map: Pose2
    speed_mps: float
    accel_mps2: float
    curvature_1pm: float
    corridor: Corridor
    stop_s_m: float
    stop_name: str
    speed_mps_max: float
    speed_reason: str
    points_map: np.ndarray
    tracks: Tracks
    predictions: Predictions
    view: View
    watched: tuple[WatchedArea, ...]
    areas: tuple[AreaAhead, ...]
    memory: PlanMemory


class Path(msgspec.Struct, frozen=True):
    """planning: what to follow now.

    points_map   (n, 2) waypoints still ahead, in order
    speeds_mps   (n,) planned speed at each
    speed_mps    the lowest of all speed commands: the one to obey now
    accel_mps2   the slope of that command as the vehicle moves along it
    limited_by   which command that was
    obstacle_m   free distance from the front bumper to the closest obstacle on the swept path, if any
    stop_m       distance still to drive to the task's stop
    emergency    brake as hard as the vehicle can
    trajectory   the same with times, from a stack that plans them; None from one that does not
    yields_to    ids of the tracks that the vehicle slows or stops for
    """

    stamp_ns: int
    points_map: np.ndarray
    speeds_mps: np.ndarray
    speed_mps: float
    limited_by: str
    obstacle_m: float | None
    stop_m: float
    emergency: bool
    accel_mps2: float = 0.0
    trajectory: Trajectory | None = None
    yields_to: tuple[int, ...] = ()


class Wish(msgspec.Struct, frozen=True):
    """control: what it would like the actuators to do."""

    steer_rad: float
    throttle_ratio: float
    brake_ratio: float
    accel_mps2: float
    diagnostics: tuple[tuple[str, float], ...] = ()


Gear = Literal["park", "reverse", "neutral", "drive"]


class Actuation(msgspec.Struct, frozen=True):
    """guard: what the actuators shall do. The only thing that `can` turns into frames."""

    enable: bool
    gear: Gear
    steer_rad: float
    throttle_ratio: float
    brake_ratio: float


class Guarded(msgspec.Struct, frozen=True):
    """guard: its verdict, for everybody after it."""

    mode: DriveMode
    intervened: str
    faults: tuple[Fault, ...]


class Says(msgspec.Struct, frozen=True):
    """hmi: texts for people outside and announcements, each once.

    screen, rear  the LED screens in front, for whom the vehicle meets, and behind, for who follows
    announce      set in the one tick in which the sentence begins
    """

    screen: str
    screen_zh: str
    announce: str
    announce_zh: str
    doors_open: bool
    rear: str = ""
    rear_zh: str = ""


class Ages(msgspec.Struct, frozen=True):
    """How old each input of the guard is, in ns; -1 when it has never come."""

    motion_ns: int
    pose_ns: int
    percept_ns: int
    path_ns: int


class Flow(msgspec.Struct, frozen=True):
    """What each room gave in one tick, in flow order: what a run records and a replay compares."""

    motion: VehicleMotion
    ego: Ego
    seen: Seen
    world: World
    task: Task
    path: Path
    wish: Wish
    act: Actuation
    verdict: Guarded
    says: Says


class Outputs(msgspec.Struct, frozen=True):
    """One tick's whole effect on the world outside the tick.

    jobs  for the workers; each answer is an item of a later tick's inbox
    """

    frames: tuple[CanFrame, ...]
    says: Says
    events: tuple[VehicleEvent, ...]
    answers: tuple[OrderAccepted | OrderRejected, ...]
    report: Status
    flow: Flow
    jobs: tuple[PlanJob, ...] = ()


def fault_report(fault: Fault) -> FaultReport:
    """A fault as the server reads it."""
    return FaultReport(fault.code, fault.severity, fault.since_ns)
