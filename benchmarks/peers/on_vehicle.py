"""Another planner in our planner's place: it answers the plan jobs of our vehicle computer.

Everything else is the vehicle as it drives for our own planner: localization and its noise, tracking, the
time from a job to its plan, the controller that follows the plan, guard and gate, CAN, by-wire and plant.
"""

import numpy as np

from benchmarks.peers.drive import Driver, begins_at, braking, others_at, road_of
from benchmarks.peers.messages import Plan, PlanRequest
from campusloop.scenes.drive import Scene
from contract.geometry import Array, project
from vehicle_agent.signals import Corridor, PlanAnswer, PlanJob, PlanMemory

_NO_PLAN_YET = np.empty((0, 7))
_SHORTEST_S = 1e-3


class VehiclePeer:
    """A planner as `vehicle_agent.stacks.choice.build_planner` returns one, for one drive.

    words       counts the planner's status texts; cycles_cpu_ms of each planning call
    unfinished  it had used planning_s_max of CPU before the end: it gets no further jobs, and stands
    """

    def __init__(self, scene: Scene, driver: Driver, planning_s_max: float) -> None:
        self.words: dict[str, int] = {}
        self.cycles_cpu_ms: list[float] = []
        self.unfinished = False
        self._driver, self._planning_s_max = driver, planning_s_max
        self._decel_mps2 = 0.9 * scene.profile.limits.decel_mps2_max
        self._plan: Array = _NO_PLAN_YET
        self._plan_ns = 0
        driver.begin(road_of(scene))

    def __call__(self, job: PlanJob) -> PlanAnswer:
        row = (
            0.0,
            job.pose_map.x_m,
            job.pose_map.y_m,
            job.pose_map.yaw_rad,
            job.speed_mps,
            job.accel_mps2 if job.speed_mps > 0.02 else 0.0,
            job.curvature_1pm,
        )
        rows = self._rows(job, row)
        if len(rows) < 2:
            before = self._plan if len(self._plan) else np.array([row])
            rows = braking(before, 1e-9 * (job.stamp_ns - self._plan_ns), row, self._decel_mps2)
        self._plan, self._plan_ns = rows, job.stamp_ns
        return PlanAnswer(
            number=job.number,
            stamp_ns=job.stamp_ns,
            line_id=job.line_id,
            trajectory=trajectory_rows(rows, job.corridor),
            limited_by="speed_limit",
            cut_s_m=np.inf,
            yields_to=np.empty(0, np.int64),
            violations=(),
            memory=PlanMemory(),
        )

    def _rows(self, job: PlanJob, row: tuple[float, ...]) -> Array:
        """The planner's rows from the job's start on; none if it has no plan, or one from elsewhere."""
        if self.unfinished:
            return _NO_PLAN_YET
        others = others_at(job.tracks, job.stamp_ns)
        plan = self._driver.plan(PlanRequest(1e-9 * job.stamp_ns, *row[1:], others))
        self._count(plan)
        rows = np.array(plan.rows)
        if len(rows) >= 2 and not begins_at(rows, row):
            self.words["begins elsewhere"] = self.words.get("begins elsewhere", 0) + 1
            return _NO_PLAN_YET
        return rows

    def _count(self, plan: Plan) -> None:
        self.cycles_cpu_ms.append(plan.cycle_cpu_ms)
        if plan.words:
            self.words[plan.words] = self.words.get(plan.words, 0) + 1
        self.unfinished = 1e-3 * sum(self.cycles_cpu_ms) > self._planning_s_max


def trajectory_rows(rows: Array, corridor: Corridor) -> Array:
    """(k, 8) rows of a `Trajectory` from the rows of a plan (PLAN_COLUMNS); times strictly rising."""
    kept = np.concatenate(([True], np.diff(rows[:, 0]) > _SHORTEST_S))
    rows = rows[kept]
    s_m = corridor.s_m - corridor.s_m[0]
    way_m = np.empty(len(rows))
    segment = 0
    for k, (x_m, y_m) in enumerate(rows[:, 1:3]):
        first = 0 if k == 0 else max(0, segment - 3)
        last = len(s_m) if k == 0 else segment + 40
        along_m, _, segment = project(corridor.points_map, s_m, x_m, y_m, first, last)
        way_m[k] = corridor.s_m[0] + along_m
    trajectory: Array = np.column_stack(
        (
            rows[:, 0] - rows[0, 0],
            rows[:, 1],
            rows[:, 2],
            np.unwrap(rows[:, 3]),
            rows[:, 6],
            np.maximum(rows[:, 4], 0.0),
            rows[:, 5],
            np.maximum.accumulate(way_m),
        )
    )
    return trajectory
