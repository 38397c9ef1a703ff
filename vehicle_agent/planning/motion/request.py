"""The motion planner's requests, parameters and answers."""

from typing import Literal, NamedTuple

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.motion.clearance import Box
from vehicle_agent.planning.motion.path.gp_path import PathWeights
from vehicle_agent.planning.motion.speed.speed_qp import SpeedWeights
from vehicle_agent.signals import Corridor, PathGraph

PASS_FREE, PASS_YIELD = 0, 1


class MotionRequestError(ValueError):
    """A motion request that cannot be understood: a wrong shape, or a number that is none."""


class StartState(msgspec.Struct, frozen=True):
    """The rear-axle centre's pose and motion at time 0.

    held_jerk_mps3  of the first 0.2 s, whose pedals are already commanded; None without such a bound
    """

    pose_map: Pose2
    speed_mps: float
    accel_mps2: float = 0.0
    curvature_1pm: float = 0.0
    held_jerk_mps3: float | None = None


class Vehicle(msgspec.Struct, frozen=True):
    """The vehicle's outline and steering; rear_overhang_m from the rear axle to the rear bumper.

    nose_m          this length of the body, from the bumper back, can run into a person; people alongside the
                    rest of it keep clear themselves
    curvature_rate  how fast the path's curvature may change in time (1/m/s): steering rate / wheelbase
    """

    length_m: float = 4.35
    width_m: float = 1.63
    rear_overhang_m: float = 0.85
    wheelbase_m: float = 2.6
    curvature_1pm_max: float = 0.2
    curvature_rate_1pmps_max: float = 0.23
    nose_m: float = 1.5

    @property
    def box(self) -> Box:
        return Box(self.length_m - self.rear_overhang_m, self.rear_overhang_m, 0.5 * self.width_m)


class DrivingLimits(msgspec.Struct, frozen=True):
    """Limits of the motion; decelerations are positive.

    accel_fade_1ps      by so much the largest acceleration falls for each 1 m/s; at rest it is accel_mps2_max
    decel_mps2_comfort  before limits and stops that are known of
    decel_mps2_max      the hard bound of an ordinary plan
    hard_decel_mps2     of the emergency braking profile alone, together with hard_jerk_mps3
    """

    speed_mps_max: float = 4.17
    accel_mps2_max: float = 1.0
    accel_fade_1ps: float = 0.0
    decel_mps2_comfort: float = 0.8
    decel_mps2_max: float = 1.8
    jerk_mps3_max: float = 1.7
    lateral_accel_mps2_max: float = 0.8
    hard_decel_mps2: float = 5.0
    hard_jerk_mps3: float = 30.0


class ClearanceLaw(NamedTuple):
    """Speed by clearance to a pedestrian, eq. 2 of Snow Lion: three points, linear between.

    A tuple, so that kernels take it as it is.
    """

    delta_m_min: float = 0.2
    delta_m_mdn: float = 0.6
    delta_m_max: float = 1.2
    speed_mps_min: float = 0.2
    speed_mps_mdn: float = 2.5
    speed_mps_max: float = 4.2


class SuddenStep(NamedTuple):
    """A step out of one's straight way: its speed approaches mps with the time constant rise_s.

    From 1 s on, it covers 99.1 % or more of how far recorded people come off their straight way
    (`benchmarks.predictions`).
    """

    mps: float
    rise_s: float


class StoppingRoom(NamedTuple):
    """The room that the guard requires before a person whom the body passes nearer than aside_m.

    The vehicle must be able to drive on for response_s, or for late_s while the person is still beside the
    way, brake with decel_mps2 and stop ahead_m before them; the guard brakes for a plan that keeps less. Or
    it must creep by the time the person could be at the body's side, so that it can pass people who stand
    beside the way.
    speed_mps_min  of the creep
    step           how a person may turn into the way
    rider_mps2     how hard a rider ahead of the vehicle may brake
    late_s         from a person's first step to braking: detection, tracking, response and pedal delay. A
                   vehicle that accelerates goes on accelerating until then
    turn_s         the same when a person who walks ahead slows down first and then turns round; 0 for riders,
                   who do not
    error_m        so much nearer to the way a person may be than they are seen

    A tuple, so that kernels take it as it is.
    """

    response_s: float = 0.35
    decel_mps2: float = 4.5
    ahead_m: float = 0.35
    aside_m: float = 1.3
    speed_mps_min: float = 0.25
    step: SuddenStep = SuddenStep(1.4, 0.5)
    rider_mps2: float = 4.0
    late_s: float = 0.55
    turn_s: float = 0.85
    error_m: float = 0.1


# A cyclist or scooter turns in faster than a person walks, brakes harder, and is out of the way as soon.
RIDER_ROOM = StoppingRoom(
    aside_m=1.3,
    speed_mps_min=1.0,
    step=SuddenStep(2.5, 0.5),
    late_s=0.7,
    response_s=0.55,
    turn_s=0.0,
    error_m=0.0,
)


class ProjectionParams(NamedTuple):
    """What the projection keeps clear of agents, as its kernels take it.

    box                          the vehicle's outline
    hard_margin_m, soft_margin_m  kept always; kept where it costs little
    law, room                    speed by clearance to a person; the room to stop before one
    rider_room                   the room to stop before a rider who turns in
    nose_m                       length of the body, from the bumper back, that can run into a person
    """

    box: Box
    hard_margin_m: float
    soft_margin_m: float
    law: ClearanceLaw
    nose_m: float
    room: StoppingRoom
    rider_room: StoppingRoom


class Agents(msgspec.Struct, frozen=True):
    """Predicted road users; arrays in the same order, a agents at k times.

    ids (a,), kinds (a,) as TRACK_KINDS; times_s (k,) rising from 0
    poses_map (a, k, 3) of the outline's middle
    sizes_m (a, 2) length, width (a person is a disc of that diameter); inflation_m (a, k) softly kept extra
    pass_rule (a,): PASS_FREE, or PASS_YIELD when the vehicle may not pass before the agent
    """

    ids: np.ndarray
    kinds: np.ndarray
    times_s: np.ndarray
    poses_map: np.ndarray
    sizes_m: np.ndarray
    inflation_m: np.ndarray
    pass_rule: np.ndarray


def no_agents() -> Agents:
    """No agents."""
    none = np.empty(0, np.int64)
    return Agents(none, none, np.zeros(1), np.empty((0, 1, 3)), np.empty((0, 2)), np.empty((0, 1)), none)


class WarmStart(msgspec.Struct, frozen=True):
    """The path of the plan before: s_m (k,) at even steps, states (k, 3) of l, l', l''."""

    s_m: np.ndarray
    states: np.ndarray


class MotionRequest(msgspec.Struct, frozen=True):
    """One motion to plan; arrays (n,) by corridor station.

    reference_l_m  the offset that the path should have; may jump
    lower_l_m, upper_l_m  where the rear-axle centre may be: hard walls
    speed_mps_max  limits that are known by place; speed_reasons: why, empty if that is not told
    end_s_m        where the rear axle must stand at the latest; inf for nowhere
    static_discs   (m, 3) x, y, radius
    s_hint_m       about where on the line the start is; a line that meets itself needs it
    """

    corridor: Corridor
    start: StartState
    reference_l_m: np.ndarray
    lower_l_m: np.ndarray
    upper_l_m: np.ndarray
    speed_mps_max: np.ndarray
    end_s_m: float = np.inf
    static_discs: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 3)))
    agents: Agents = msgspec.field(default_factory=no_agents)
    warm: WarmStart | None = None
    s_hint_m: float | None = None
    speed_reasons: tuple[SpeedLimitReason, ...] = ()


class MotionParams(msgspec.Struct, frozen=True):
    """The planner's parameters; see docs/vehicle/planning/motion.md.

    step_m, checks     distance of the support states, and check points a step
    sample_m           spacing of the path's samples, for limits and projections
    hard_margin_m      kept to every nominal place; soft_margin_m: kept where it costs little
    stop_gap_m         between the bumper and what the vehicle stops for
    gap_s              this many seconds' way stay free before a moving agent, as the guard requires
    early_s            an agent may come this much earlier than predicted
    walk_mps           a person who moves, but slower than this, may be about to walk this fast
    start_s            and comes earlier by this at walk_mps, and by more in proportion the slower they are
    yield_mps2         how hard the vehicle brakes for its speed limits beside people
    iterations_max     of path and speed together; path_iterations_max: of one path
    nodes_max          of one s-t search
    moving_m           an agent that moves less than this in the horizon is a static obstacle to the path
    doubt_mps          speed limit while a prediction is implausible
    """

    vehicle: Vehicle = Vehicle()
    limits: DrivingLimits = DrivingLimits()
    law: ClearanceLaw = ClearanceLaw()
    room: StoppingRoom = StoppingRoom()
    rider_room: StoppingRoom = RIDER_ROOM
    path: PathWeights = PathWeights()
    speed: SpeedWeights = SpeedWeights()
    smoothing_m: float = 0.6
    step_m: float = 2.0
    checks: int = 4
    sample_m: float = 0.25
    horizon_s: float = 8.0
    knot_s: float = 0.2
    row_s: float = 0.1
    hard_margin_m: float = 0.05
    soft_margin_m: float = 0.15
    stop_gap_m: float = 0.4
    gap_s: float = 0.2
    early_s: float = 0.1
    walk_mps: float = 1.3
    start_s: float = 0.3
    yield_mps2: float = 1.6
    moving_mps_min: float = 0.25
    static_margin_m: float = 0.1
    iterations_max: int = 3
    path_iterations_max: int = 25
    nodes_max: int = 60_000
    moving_m: float = 0.4
    track_mps_max: float = 30.0
    doubt_mps: float = 1.5

    @property
    def projection(self) -> ProjectionParams:
        """The parameters of the projection of agents on the path."""
        return ProjectionParams(
            self.vehicle.box,
            self.hard_margin_m,
            self.soft_margin_m,
            self.law,
            self.vehicle.nose_m,
            self.room,
            self.rider_room,
        )


Quality = Literal["planned", "stop", "emergency"]


class Motion(msgspec.Struct, frozen=True):
    """The answer; it always has rows.

    rows          (k, 8) as in signals.Trajectory: every 0.1 s until the horizon or rest
    path          the warm start of the next request
    feasible      no violations; violations: names from the independent check, or why nothing was planned
    limited_by    what keeps the vehicle from going faster
    quality       planned, stop (a comfortable one instead of a plan) or emergency
    yields_to, passes  ids of the agents that the vehicle yields to, and passes before
    cut_s_m       a stationary obstacle blocks the path from here on (rear axle); inf without one
    diagnostics   figures for the record, by name
    replaced      violations of the plan that a stop replaces, empty for a plan
    graph         the s-t graph, None without a path
    """

    rows: np.ndarray
    path: WarmStart | None
    feasible: bool
    violations: tuple[str, ...]
    limited_by: SpeedLimitReason
    quality: Quality
    iterations: int
    yields_to: np.ndarray
    passes: np.ndarray
    cut_s_m: float
    diagnostics: tuple[tuple[str, float], ...]
    replaced: tuple[str, ...] = ()
    graph: PathGraph | None = None
