"""The messages between the benchmark and an open planner in a process of its own.

One JSON object a line. `Road` begins a scene and has no answer; every `PlanRequest` is answered by a `Plan`.
The planner's process needs msgspec, its own libraries and `benchmarks.peers` only.
"""

import msgspec

# Columns of PlanRequest.others: a row for each visible road user, map frame, the middle of the outline.
OTHER_COLUMNS = ("number", "x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps", "length_m", "width_m", "is_person")
# Columns of Plan.rows: the rear-axle centre at times from now on.
PLAN_COLUMNS = ("t_s", "x_m", "y_m", "yaw_rad", "v_mps", "a_mps2", "curvature_1pm")


class Road(msgspec.Struct, frozen=True, tag="road"):
    """A scene begins.

    path              (n) points (x, y) of the rear axle, map frame, about a metre apart
    width_m           of the road, its middle the path
    speed_mps_max     the cap, as for every other driver of the scene
    accel_mps2_max .. curvature_1pm_max   of the vehicle
    """

    path: list[tuple[float, float]]
    width_m: float
    length_m: float
    body_width_m: float
    rear_overhang_m: float
    wheelbase_m: float
    speed_mps_max: float
    accel_mps2_max: float
    decel_mps2_max: float
    lateral_accel_mps2_max: float
    steer_rate_radps_max: float
    curvature_1pm_max: float


class PlanRequest(msgspec.Struct, frozen=True, tag="ask"):
    """Plan from this state of the rear axle on. others: rows of OTHER_COLUMNS, constant velocities."""

    t_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    v_mps: float
    a_mps2: float
    curvature_1pm: float
    others: list[tuple[float, ...]]


class Plan(msgspec.Struct, frozen=True, tag="plan"):
    """rows of PLAN_COLUMNS, empty without a plan; words: the planner's status text, or its exception's.

    cycle_cpu_ms, cycle_wall_ms  of its planning call alone
    prepare_cpu_ms               of turning the others into its own obstacles
    """

    rows: list[tuple[float, ...]]
    words: str
    cycle_cpu_ms: float
    cycle_wall_ms: float
    prepare_cpu_ms: float


class Ready(msgspec.Struct, frozen=True, tag="ready"):
    """The planner is loaded: its name, version and licence as its package states them."""

    name: str
    version: str
    licence: str


ToPlanner = Road | PlanRequest
FromPlanner = Ready | Plan
