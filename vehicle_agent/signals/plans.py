"""mission, planning: the task, the motion planner's jobs and answers, and the path."""

from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.roads.areas import AreaAhead
from contract.roads.routing import ReferenceLine
from contract.wire.reasons import HoldReason, SpeedLimitReason
from vehicle_agent.signals.surroundings import Predictions, Tracks, View, WatchedArea

TaskMode = Literal["idle", "drive", "dwell", "hold"]
# stop_occupied: waits short of a stop that another vehicle stands on.
TaskReason = Literal["no_order", "requested_stop", "people_near", "stop_occupied"]


class Task(msgspec.Struct, frozen=True):
    """mission: where to drive to and where to stop, along one reference line.

    line          the remaining route; the same object until the order changes
    line_id       grows by one whenever `line` is another
    s_m           the rear axle's place on the line
    stop_s_m      where the rear axle must stand, at the latest: visit, hold point or temporary stop
    waiting_for   section without a grant, when that is the reason for stop_s_m
    hold_reason, hold_detail  why the mode is hold; the operator's own text, or which visit is unreachable
    resumed_ns    stamp of an operator's last resume, 0 before; it releases older latched stops
    waved_on_ns   stamp of the last resume of a vehicle that was not held, 0 before: an operator has looked,
                  and it need not wait for people whom it does not see
    announcement, announcement_zh  an operator's announcement, new when announced_ns grows; without the second
                  it is in a single language
    refused_ns    when the seat button was last refused under way, 0 before
    utc_ns        the server's clock now, 0 before its first word
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
    reason: TaskReason | None
    hold_reason: HoldReason | None = None
    hold_detail: str = ""
    resumed_ns: int = 0
    announcement: str = ""
    announcement_zh: str = ""
    announced_ns: int = 0
    refused_ns: int = 0
    utc_ns: int = 0
    waved_on_ns: int = 0


class Trajectory(msgspec.Struct, frozen=True):
    """Where the rear-axle centre is to be at each time.

    stamp_ns  vehicle clock at row 0
    rows      (k, 8) t_s since stamp_ns, x_m, y_m, yaw_rad (map, continuous along the rows), curvature_1pm,
              speed_mps, accel_mps2, s_m along the task's line; times strictly rising
    """

    stamp_ns: int
    rows: np.ndarray


class Corridor(msgspec.Struct, frozen=True):
    """A window of the task's line at even steps, with map data by station; all arrays (n, ...).

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


class PlanMemory(msgspec.Struct, frozen=True):
    """What the planner hands to its next job; (0,) and (0, 3) arrays when there is nothing.

    offset_m     the lateral offset chosen, and for how many plans in a row another one has been better
    path_s_m, path_l_m  (n,) and (n, 3) the last path: offset and its two derivatives along the line
    stopping_for areas that it stops before; driving on needs a larger gap than stopping did
    """

    offset_m: float = 0.0
    better_offset_m: float = 0.0
    better_count: int = 0
    path_s_m: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0))
    path_l_m: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 3)))
    stopping_for: tuple[str, ...] = ()


class PlanJob(msgspec.Struct, frozen=True, tag="plan_job"):
    """Everything that one motion plan depends on; the planner itself has no state.

    stamp_ns     vehicle clock at the start state, where the trajectory begins
    pose_map, speed_mps, accel_mps2, curvature_1pm   the start state: where the vehicle is expected then
    held_jerk_mps3  of the first 0.2 s, whose pedals are already commanded; None without such a bound
    stop_s_m     where the rear axle must stand at the latest
    speed_mps_max, speed_reason  the lowest of all limits that hold everywhere, and its reason
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
    stop_reason: SpeedLimitReason
    speed_mps_max: float
    speed_reason: SpeedLimitReason
    points_map: np.ndarray
    tracks: Tracks
    predictions: Predictions
    view: View
    watched: tuple[WatchedArea, ...]
    areas: tuple[AreaAhead, ...]
    memory: PlanMemory
    held_jerk_mps3: float | None = None


class PathLimit(msgspec.Struct, frozen=True):
    """A speed limit on a stretch of the path, ways from the plan's start."""

    from_m: float
    to_m: float
    speed_mps: float
    reason: SpeedLimitReason


class PathGraph(msgspec.Struct, frozen=True):
    """The s-t graph of a plan, for people to read: nothing drives by it. Ways in centimetres, int16.

    dt_s               between knots
    way_cm             (K,) of the rear axle from the plan's start: the motion that was chosen
    low_cm, high_cm    (K,) the corridor; UNBOUNDED_CM and -UNBOUNDED_CM where nothing bounds it
    ids                (a,) tracks that come onto the path
    from_cm, to_cm     (K, a) the stretch that each occupies; from > to: none
    limits             by place, nearest first
    """

    dt_s: float
    way_cm: np.ndarray
    low_cm: np.ndarray
    high_cm: np.ndarray
    ids: np.ndarray
    from_cm: np.ndarray
    to_cm: np.ndarray
    limits: tuple[PathLimit, ...]


UNBOUNDED_CM = 32_000


class PlanAnswer(msgspec.Struct, frozen=True, tag="plan_answer"):
    """The motion planner's answer to the job of the same number.

    stamp_ns     of the job: the vehicle clock at row 0 of the trajectory
    trajectory   (k, 8) see `Trajectory`; no rows when no motion at all could be planned
    limited_by   what keeps the vehicle from going faster; also for people to read
    cut_s_m      a stationary obstacle blocks the line for the rear axle from here on (the paper's pi_s); inf
                 without one
    yields_to    ids of the tracks that it slows or stops for
    violations   what the independent check found wrong, empty for a feasible trajectory
    memory       handed back with the next job
    graph        None without a plan on a path
    """

    number: int
    stamp_ns: int
    line_id: int
    trajectory: np.ndarray
    limited_by: SpeedLimitReason
    cut_s_m: float
    yields_to: np.ndarray
    violations: tuple[str, ...]
    memory: PlanMemory
    graph: PathGraph | None = None


class Path(msgspec.Struct, frozen=True):
    """planning: what to follow now.

    points_map   (n, 2) waypoints still ahead, in order
    speeds_mps   (n,) planned speed at each
    speed_mps    the lowest of all speed commands, which control follows now
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
    limited_by: SpeedLimitReason
    obstacle_m: float | None
    stop_m: float
    emergency: bool
    accel_mps2: float = 0.0
    trajectory: Trajectory | None = None
    yields_to: tuple[int, ...] = ()
