"""A scene driven by another planner, with the same road, people and tracker; its plans are followed exactly.

At every step the vehicle is where the present plan says. There is no delay, no actuator, no localization
error and no planning time, so only the planner itself can fail. Our stack drives the same scene with all of
them. If a planner has no plan, the vehicle brakes hard along its last plan.
"""

import math
from collections import deque
from typing import Protocol

import numpy as np

from benchmarks.peers.messages import Plan, PlanRequest, Road
from campusloop.scenes.contact_metrics import contact_metrics
from campusloop.scenes.drive import VEHICLE_ID, Scene, SceneRun
from campusloop.scenes.path_map import LANE_ID, extended
from campusloop.scenes.trace import SceneTrace
from campusloop.virtual.conductor import STEP_NS
from contract.geometry import Array, Pose2, pose_at, project
from contract.roads.network import RoadNetwork
from contract.roads.walls import wall_edges
from simulator.sensors.tracker import Tracker
from simulator.traffic.actors import no_bodies
from simulator.traffic.corridor import SAMPLES, Corridor
from simulator.traffic.crowd import VEHICLE_COLUMNS
from vehicle_agent.perception.tracker import AlphaBetaTracker, TrackerState
from vehicle_agent.signals import PEDESTRIAN, Tracks

_PLAN_EVERY_STEPS = 5
_BEYOND_M = (5.0, 60.0)
# A plan must begin at the vehicle, except for its rounding and smoothing; otherwise it is rejected.
_JUMP_M_MAX = 0.5
_ELSEWHERE = "begins elsewhere"
_BRAKES_SHARE = 0.9
_STILL_MPS = 0.2
_STANDS_MPS = 0.02
# As for the Snow Lion vehicle on clips, so that our comfort limits do not slow a peer down.
_LATERAL_MPS2 = 2.0


class Driver(Protocol):
    """`begin` passes the road; `plan` is called ten times a second."""

    def begin(self, road: Road) -> None: ...

    def plan(self, request: PlanRequest) -> Plan: ...


class PeerDrive:
    """One scene and one driver; `run` drives it to its end. `words` counts the planner's status texts.

    unfinished  the planner had used planning_s_max of CPU before the end: the drive does not count
    """

    def __init__(self, scene: Scene, driver: Driver, planning_s_max: float = math.inf) -> None:
        self.unfinished = False
        self._planning_s_max = planning_s_max
        self.scene, self._driver = scene, driver
        network = RoadNetwork(scene.road_map)
        line = network.lines[LANE_ID]
        self._points, self._s = line.points, line.s
        self._segment = int(np.searchsorted(self._s, scene.start_s_m))
        self._corridor = Corridor(network)
        self._tracker = Tracker(
            scene.options.tracker,
            wall_edges(scene.road_map.buildings),
            scene.profile.lidar.x_m,
            np.random.default_rng([scene.seed, *f"tracker {VEHICLE_ID}".encode()]),
        )
        self._filter, self._filter_state = AlphaBetaTracker(), TrackerState()
        x, y, yaw = pose_at(self._points, self._s, scene.start_s_m)
        self._row: tuple[float, ...] = (0.0, x, y, yaw, scene.start_mps, 0.0, 0.0)
        self._plan = np.array([self._row])
        self._age_s = 0.0
        self._odometer_m = 0.0
        self._poses: deque[tuple[int, Pose2]] = deque(maxlen=100)
        self._vehicles: Array = np.zeros((1, VEHICLE_COLUMNS))
        self._ahead: Array = np.zeros((1, SAMPLES, 2))
        self.words: dict[str, int] = {}
        self.cycles_cpu_ms: list[float] = []
        self.prepares_cpu_ms: list[float] = []
        driver.begin(road_of(scene))

    def run(self) -> SceneRun:
        scene, trace = self.scene, SceneTrace()
        way_m = [scene.start_s_m]
        steps = math.floor(scene.limit_s * 1e9 / STEP_NS)
        for k in range(steps):
            now_ns = (k + 1) * STEP_NS
            self._take_percepts(now_ns)
            if k % _PLAN_EVERY_STEPS == 0:
                self._take(self._driver.plan(self._plan_request(now_ns)))
            self._age_s += STEP_NS * 1e-9
            self._move()
            trace.rows.append(self._trace_row((k + 1) * STEP_NS * 1e-9))
            trace.agents.append(scene.actors.bodies() if scene.actors else no_bodies())
            way_m.append(self._way_m())
            if way_m[-1] >= scene.goal_s_m:
                break
            if 1e-3 * sum(self.cycles_cpu_ms) > self._planning_s_max:
                self.unfinished = True
                break
        rows, reached = trace.array(), way_m[-1] >= scene.goal_s_m
        return SceneRun(
            scene.name,
            float(rows[-1, 0]) if reached else None,
            way_m[-1] - scene.start_s_m,
            trace,
            contact_metrics(rows, trace.agents, scene.profile.body),
            tuple(self.cycles_cpu_ms),
            0.0,
            tuple(sorted(self.words.items(), key=lambda item: -item[1])),
            way_m=tuple(way_m[1:]),
        )

    def _take_percepts(self, now_ns: int) -> None:
        """Take the tracker's percepts, filtered as in our perception, with the pose at each scan."""
        pose = Pose2(*self._row[1:4])
        self._poses.append((now_ns, pose))
        bodies = self.scene.actors.bodies() if self.scene.actors else no_bodies()
        for percept in self._tracker.percepts(now_ns, pose, bodies):
            seen_from = next(pose for stamp_ns, pose in self._poses if stamp_ns == percept.stamp_ns)
            self._filter_state = self._filter.step(self._filter_state, percept, seen_from)

    def _plan_request(self, now_ns: int) -> PlanRequest:
        others = others_at(self._filter_state.tracks, now_ns)
        _, x, y, yaw, v, a, curvature = self._row
        if v < _STANDS_MPS:
            # At rest nothing decelerates: a start state that does has no way on but backwards.
            v, a = 0.0, 0.0
        return PlanRequest((now_ns - STEP_NS) * 1e-9, x, y, yaw, v, a, curvature, others)

    def _take(self, plan: Plan) -> None:
        self.cycles_cpu_ms.append(plan.cycle_cpu_ms)
        self.prepares_cpu_ms.append(plan.prepare_cpu_ms)
        if plan.words:
            self.words[plan.words] = self.words.get(plan.words, 0) + 1
        rows = np.array(plan.rows)
        if len(rows) >= 2 and not begins_at(rows, self._row):
            self.words[_ELSEWHERE] = self.words.get(_ELSEWHERE, 0) + 1
            rows = rows[:0]
        if len(rows) >= 2:
            self._plan = rows
        else:
            decel = _BRAKES_SHARE * self.scene.profile.limits.decel_mps2_max
            self._plan = braking(self._plan, self._age_s, self._row, decel)
        self._age_s = 0.0

    def _move(self) -> None:
        before = self._row
        self._row = row_at(self._plan, self._age_s)
        self._odometer_m += math.hypot(self._row[1] - before[1], self._row[2] - before[2])
        body = self.scene.profile.body
        _, x, y, yaw, v, _, _ = self._row
        self._vehicles[0] = (
            x, y, yaw, body.rear_overhang_m, body.front_overhang_m, 0.5 * body.width_m, v,
        )  # fmt: skip
        self._corridor.update(Pose2(x, y, yaw))
        self._ahead[0] = self._corridor.ahead
        if self.scene.actors is not None:
            dt_s = STEP_NS * 1e-9
            self.scene.actors.step(self._vehicles, np.array([self._odometer_m]), self._ahead, dt_s)

    def _trace_row(self, t_s: float) -> tuple[float, ...]:
        _, x, y, yaw, v, a, curvature = self._row
        return (t_s, x, y, yaw, v, a, math.atan(self.scene.profile.body.wheelbase_m * curvature))

    def _way_m(self) -> float:
        s_m, _, self._segment = project(
            self._points, self._s, self._row[1], self._row[2], self._segment - 3, self._segment + 6
        )
        return float(s_m)


def road_of(scene: Scene) -> Road:
    """The scene's road, with a straight extension so that no planning horizon ends at the path's end."""
    lane = next(lane for lane in scene.road_map.lanes if lane.lane_id == LANE_ID)
    body, limits = scene.profile.body, scene.profile.limits
    path = extended(np.array(lane.points), *_BEYOND_M)
    return Road(
        [(float(x), float(y)) for x, y in path],
        lane.width_m,
        body.length_m,
        body.width_m,
        body.rear_overhang_m,
        body.wheelbase_m,
        min(limits.speed_mps_max, lane.speed_limit_mps),
        limits.accel_mps2_max,
        limits.decel_mps2_max,
        max(limits.lateral_accel_mps2_max, _LATERAL_MPS2),
        limits.steer_rate_radps_max,
        1.0 / body.turn_radius_m_min,
    )


def others_at(tracks: Tracks, now_ns: int) -> list[tuple[float, ...]]:
    """Rows of OTHER_COLUMNS: tracks predicted to now by their velocity; slow ones are set to standing."""
    late_s = (now_ns - tracks.stamp_ns) * 1e-9
    velocities = tracks.velocities_map_mps.copy()
    velocities[np.hypot(velocities[:, 0], velocities[:, 1]) < _STILL_MPS] = 0.0
    places = tracks.poses_map[:, :2] + late_s * velocities
    is_person = (tracks.kinds == PEDESTRIAN).astype(np.float64)
    table = np.column_stack(
        (tracks.ids, places, tracks.poses_map[:, 2], velocities, tracks.sizes_m, is_person)
    )
    return [tuple(row) for row in table.tolist()]


def begins_at(rows: Array, row: tuple[float, ...]) -> bool:
    """The plan's rows (PLAN_COLUMNS) are numbers, and begin at this row but for rounding and smoothing."""
    jump_m = math.hypot(rows[0, 1] - row[1], rows[0, 2] - row[2])
    return bool(np.isfinite(rows).all()) and jump_m <= _JUMP_M_MAX


def row_at(plan: Array, age_s: float) -> tuple[float, ...]:
    """The plan's row (PLAN_COLUMNS) at a time, interpolated between rows; after its end it stands."""
    times = plan[:, 0]
    if age_s >= times[-1]:
        _, x, y, yaw, _, _, curvature = plan[-1]
        return (age_s, float(x), float(y), float(yaw), 0.0, 0.0, float(curvature))
    i = int(np.searchsorted(times, age_s, side="right")) - 1
    share = (age_s - times[i]) / (times[i + 1] - times[i])
    row = plan[i] + share * (plan[i + 1] - plan[i])
    turned = math.remainder(plan[i + 1, 3] - plan[i, 3], math.tau)
    row[3] = plan[i, 3] + share * turned
    return tuple(row.tolist())


def braking(plan: Array, age_s: float, row: tuple[float, ...], decel_mps2: float) -> Array:
    """A stop at a constant rate along the rest of a plan, and straight on if that is too short."""
    speed_mps = max(0.0, row[4])
    left = np.vstack((np.array([row]), plan[plan[:, 0] > age_s]))
    way_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(left[:, 1:3], axis=0).T))))
    stop_s = speed_mps / decel_mps2
    times = np.linspace(0.0, max(stop_s, 0.02), 12)
    rows = []
    for t_s in times:
        v = max(0.0, speed_mps - decel_mps2 * t_s)
        s_m = max(0.0, speed_mps * t_s - 0.5 * decel_mps2 * t_s * t_s)
        x, y, curvature = (float(np.interp(s_m, way_m, left[:, k])) for k in (1, 2, 6))
        yaw = float(np.interp(s_m, way_m, np.unwrap(left[:, 3])))
        beyond_m = max(0.0, s_m - float(way_m[-1]))
        x, y = x + beyond_m * math.cos(yaw), y + beyond_m * math.sin(yaw)
        rows.append((t_s, x, y, yaw, v, -decel_mps2 if v > 0.0 else 0.0, curvature))
    return np.array(rows)
