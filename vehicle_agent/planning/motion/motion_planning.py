"""The Snow Lion stack's planning in the tick: requests motion plans, and follows the last answer.

The tick itself neither searches nor optimizes. It keeps a trajectory, requests a new one, or, when no planner
answers, turns it into a stop.
"""

import math

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.roads.areas import AreaAhead, areas_ahead
from contract.roads.network import RoadNetwork
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.motion import trajectory_lookup
from vehicle_agent.planning.motion.cadence import Cadence
from vehicle_agent.planning.motion.corridor import NO_CORRIDOR, corridor_of, window
from vehicle_agent.planning.motion.request import StartState
from vehicle_agent.planning.motion.seen_kerbs import narrowed
from vehicle_agent.planning.waypoint.following import stop_reason
from vehicle_agent.signals import (
    Corridor,
    Ego,
    Path,
    PlanAnswer,
    PlanJob,
    PlanMemory,
    Task,
    Trajectory,
    World,
)
from vehicle_agent.signals.poor_position import position_limit_mps
from vehicle_agent.signals.rates import PLAN_ANSWER_AGE_NS_MAX

_AHEAD_ROWS_S = 6.0
# Until a pedal takes effect the vehicle follows earlier commands. It misses a plan that begins otherwise, and
# control would brake harder later to make up for it. The motion planner's first piece is as long.
_HELD_NS, _MOVES_MPS = 200_000_000, 0.5
# A plan goes on from the one before, and not from the vehicle, whose noise would come back to the wheels.
# But it must not run away from a vehicle that sets off late or is heavier than its profile. Beside people it
# allows what suits its own speed, and the vehicle catches up with more than the plan's acceleration.
_LEAD_MPS = 0.15
_NOWHERE = np.empty((0, 2))
_NO_SPEEDS = np.empty(0)


class MotionPlanningState(msgspec.Struct, frozen=True):
    """What planning remembers.

    corridor   the whole line; areas: its passes through observation areas
    answer     the plan being driven; stopping: its fallback, once no plan comes
    waiting_ns since when jobs have gone unanswered, 0 while they have not
    asked_*    of the last job; job: the one of this very tick
    """

    line_id: int = 0
    corridor: Corridor = NO_CORRIDOR
    areas: tuple[AreaAhead, ...] = ()
    ticks: int = 0
    jobs: int = 0
    answer: PlanAnswer | None = None
    stopping: Trajectory | None = None
    waiting_ns: int = 0
    job_stop_m: float = math.inf
    job_limit_mps: float = math.inf
    near_road_users: bool = False
    job: PlanJob | None = None


class MotionPlanning:
    """lead_ns        from a job to the moment its trajectory begins: the planner and the way to it and back
    answer_ns_max  a plan that was asked for and does not come within this time ends in a stop
    kerb_keep_m    steps of the ground nearer to the line than this are none of its edges (`seen_kerbs`)
    """

    def __init__(
        self,
        network: RoadNetwork,
        speed_mps_max: float,
        wheelbase_m: float,
        cadence: Cadence | None = None,
        stop_mps2: float = 1.2,
        lead_ns: int = 60_000_000,
        answer_ns_max: int = PLAN_ANSWER_AGE_NS_MAX,
        behind_m: float = 8.0,
        ahead_m: float = 55.0,
        kerb_keep_m: float = 1.2,
    ) -> None:
        self._network = network
        self._speed_mps_max = speed_mps_max
        self._wheelbase_m = wheelbase_m
        self._cadence = cadence or Cadence()
        self._stop_mps2 = stop_mps2
        self._lead_ns = lead_ns
        self._answer_ns_max = answer_ns_max
        self._behind_m = behind_m
        self._ahead_m = ahead_m
        self._kerb_keep_m = kerb_keep_m

    def initial(self) -> MotionPlanningState:
        return MotionPlanningState()

    def jobs(self, state: MotionPlanningState) -> tuple[PlanJob, ...]:
        return () if state.job is None else (state.job,)

    def step(
        self, state: MotionPlanningState, ego: Ego, world: World, task: Task, plans: tuple[PlanAnswer, ...]
    ) -> tuple[Path, MotionPlanningState]:
        """The trajectory to follow now. Without a line, or with nothing to drive to: stand still."""
        state = msgspec.structs.replace(state, ticks=state.ticks + 1, job=None)
        if task.line is None:
            return _standing(ego, "no_order", 0.0), MotionPlanningState(ticks=state.ticks, jobs=state.jobs)
        if task.line_id != state.line_id:
            corridor = corridor_of(task.line, self._network)
            areas = areas_ahead(self._network, task.line)
            kept = MotionPlanningState(task.line_id, corridor, areas, ticks=state.ticks, jobs=state.jobs)
            # The present trajectory stays valid until there is a plan for the new line.
            state = msgspec.structs.replace(kept, stopping=_moving_stop(state, ego, self._stop_mps2))
        state = self._with_newest_plan(state, plans)
        limit_mps, reason = self._limit(ego, world)
        state = self._with_job_if_due(state, ego, world, task, limit_mps, reason)
        return self._path(state, ego, task, reason if limit_mps <= 0.0 else None)

    def _with_newest_plan(
        self, state: MotionPlanningState, plans: tuple[PlanAnswer, ...]
    ) -> MotionPlanningState:
        """The newest plan for this line replaces the one before."""
        newest = state.answer
        for plan in plans:
            if plan.line_id == state.line_id and (newest is None or plan.number > newest.number):
                newest = plan
        if newest is state.answer or newest is None or len(newest.trajectory) < 2:
            return state
        return msgspec.structs.replace(state, answer=newest, stopping=None, waiting_ns=0)

    def _limit(self, ego: Ego, world: World) -> tuple[float, SpeedLimitReason]:
        """The speed that holds wherever the vehicle is, and what for."""
        if not ego.valid:
            return 0.0, "no_position"
        if world.blind:
            return 0.0, "blind"
        limit_mps = position_limit_mps(ego.position_std_m)
        if limit_mps < self._speed_mps_max:
            return limit_mps, "poor_position"
        return self._speed_mps_max, "speed_limit"

    def _with_job_if_due(
        self,
        state: MotionPlanningState,
        ego: Ego,
        world: World,
        task: Task,
        limit_mps: float,
        reason: SpeedLimitReason,
    ) -> MotionPlanningState:
        """With a job when there is reason to plan."""
        every = self._cadence.every_ticks
        if state.ticks % every or not ego.valid or not len(state.corridor.s_m):
            return state
        stands = ego.speed_mps < 0.05
        if stands and (task.mode in ("idle", "dwell") or task.stop_s_m - task.s_m < 0.05):
            return state
        near = window(state.corridor, task.s_m, self._behind_m, self._ahead_m)
        near = narrowed(near, world.kerbs_map, self._kerb_keep_m)
        near_road_users = self._cadence.is_near_road_users(world, near, ego)
        if not (near_road_users or state.near_road_users or self._has_changed(state, ego, task, limit_mps)):
            return state
        return self._with_job(
            msgspec.structs.replace(state, near_road_users=near_road_users),
            near,
            ego,
            world,
            task,
            limit_mps,
            reason,
        )

    def _has_changed(self, state: MotionPlanningState, ego: Ego, task: Task, limit_mps: float) -> bool:
        answer = state.answer
        if answer is None or state.stopping is not None:
            return True
        if abs(task.stop_s_m - state.job_stop_m) > 0.02 or limit_mps != state.job_limit_mps:
            return True
        driven = Trajectory(answer.stamp_ns, answer.trajectory)
        if self._cadence.is_running_out(driven, ego.stamp_ns):
            return True
        here = trajectory_lookup.row_at(driven, ego.stamp_ns)
        if self._cadence.is_off_trajectory(here, ego):
            return True
        ended = ego.stamp_ns - answer.stamp_ns > answer.trajectory[-1, 0] * 1e9
        return bool(ended and task.stop_s_m - task.s_m > 0.05)

    def _with_job(
        self,
        state: MotionPlanningState,
        near: Corridor,
        ego: Ego,
        world: World,
        task: Task,
        limit_mps: float,
        reason: SpeedLimitReason,
    ) -> MotionPlanningState:
        begin_ns = ego.stamp_ns + self._lead_ns
        start = self._next_start(state, ego, begin_ns)
        low, high = near.points_map.min(axis=0) - 8.0, near.points_map.max(axis=0) + 8.0
        boxed = ((low <= world.points_map) & (world.points_map <= high)).all(axis=1)
        job = PlanJob(
            number=state.jobs + 1,
            stamp_ns=begin_ns,
            line_id=state.line_id,
            pose_map=start.pose_map,
            speed_mps=start.speed_mps,
            accel_mps2=start.accel_mps2,
            curvature_1pm=start.curvature_1pm,
            corridor=near,
            stop_s_m=task.s_m if task.mode in ("idle", "dwell") else task.stop_s_m,
            stop_reason=stop_reason(task),
            speed_mps_max=limit_mps,
            speed_reason=reason,
            points_map=world.points_map[boxed],
            tracks=world.tracks,
            predictions=world.predictions,
            view=world.view,
            watched=world.watched,
            areas=tuple(
                area
                for area in state.areas
                if near.s_m[0] <= area.leave_s_m and area.stop_s_m <= near.s_m[-1]
            ),
            memory=state.answer.memory if state.answer is not None else PlanMemory(),
            held_jerk_mps3=start.held_jerk_mps3,
        )
        return msgspec.structs.replace(
            state,
            jobs=state.jobs + 1,
            waiting_ns=state.waiting_ns or ego.stamp_ns,
            job_stop_m=task.stop_s_m,
            job_limit_mps=limit_mps,
            job=job,
        )

    def _next_start(self, state: MotionPlanningState, ego: Ego, begin_ns: int) -> StartState:
        """The state at which the next trajectory begins.

        On the present trajectory while the vehicle follows it closely, at a speed near the vehicle's, else
        where the vehicle is predicted to be.
        """
        driven = _driven(state)
        if driven is not None:
            here = trajectory_lookup.row_at(driven, ego.stamp_ns)
            if not self._cadence.is_off_trajectory(here, ego):
                start = _start_on(driven, begin_ns)
                lead_mps = float(here[trajectory_lookup.SPEED]) - ego.speed_mps
                excess_mps = lead_mps - min(max(lead_mps, -_LEAD_MPS), _LEAD_MPS)
                return msgspec.structs.replace(start, speed_mps=max(start.speed_mps - excess_mps, 0.0))
        dt_s = (begin_ns - ego.stamp_ns) * 1e-9
        yaw_rad = ego.pose_map.yaw_rad + 0.5 * dt_s * ego.yaw_rate_radps
        pose = Pose2(
            ego.pose_map.x_m + dt_s * ego.speed_mps * math.cos(yaw_rad),
            ego.pose_map.y_m + dt_s * ego.speed_mps * math.sin(yaw_rad),
            ego.pose_map.yaw_rad + dt_s * ego.yaw_rate_radps,
        )
        speed_mps = max(0.0, ego.speed_mps)
        # The guard has braked harder than any plan. It lets go at once, while a plan that began with its
        # braking would end it at a comfortable jerk, seconds later and at rest.
        accel_mps2 = max(ego.accel_mps2, -self._stop_mps2)
        return StartState(pose, speed_mps, accel_mps2, math.tan(ego.steer_rad) / self._wheelbase_m)

    def _path(
        self, state: MotionPlanningState, ego: Ego, task: Task, halt: SpeedLimitReason | None
    ) -> tuple[Path, MotionPlanningState]:
        stop_m = task.stop_s_m - task.s_m
        driven = _driven(state)
        silent = state.waiting_ns > 0 and ego.stamp_ns - state.waiting_ns > self._answer_ns_max
        if driven is not None and state.stopping is None and (halt or silent):
            stopping = trajectory_lookup.stopping(driven, ego.stamp_ns, self._stop_mps2)
            state = msgspec.structs.replace(state, stopping=stopping)
            driven = stopping
        if driven is None or (task.mode in ("idle", "dwell") and ego.speed_mps < 0.05):
            reason: SpeedLimitReason = task.mode if task.mode != "drive" else halt or "no_plan"
            return _standing(ego, reason, stop_m), state
        answer = state.answer
        limited_by: SpeedLimitReason = halt or "no_plan"
        if not halt and answer is not None and state.stopping is None:
            limited_by = answer.limited_by
        row = trajectory_lookup.row_at(driven, ego.stamp_ns)
        ahead = _ahead(driven, ego.stamp_ns)
        yields_to = () if answer is None else tuple(int(number) for number in answer.yields_to)
        path = Path(
            stamp_ns=ego.stamp_ns,
            points_map=ahead[:, trajectory_lookup.X : trajectory_lookup.Y + 1].copy(),
            speeds_mps=ahead[:, trajectory_lookup.SPEED].copy(),
            speed_mps=float(row[trajectory_lookup.SPEED]),
            limited_by=limited_by,
            obstacle_m=self._obstacle_m(state, task),
            stop_m=stop_m,
            emergency=False,
            accel_mps2=float(row[trajectory_lookup.ACCEL]),
            trajectory=driven,
            yields_to=yields_to,
        )
        return path, state

    def _obstacle_m(self, state: MotionPlanningState, task: Task) -> float | None:
        """Free way to the obstacle that blocks the line; None without one.

        The cut is where the rear axle is when the bumper meets it.
        """
        if state.answer is None or math.isinf(state.answer.cut_s_m):
            return None
        return max(0.0, state.answer.cut_s_m - task.s_m)


def _start_on(driven: Trajectory, begin_ns: int) -> StartState:
    """The state of the trajectory at a time."""
    row = trajectory_lookup.row_at(driven, begin_ns)
    pose = Pose2(
        float(row[trajectory_lookup.X]), float(row[trajectory_lookup.Y]), float(row[trajectory_lookup.YAW])
    )
    speed_mps, accel_mps2 = float(row[trajectory_lookup.SPEED]), float(row[trajectory_lookup.ACCEL])
    later = trajectory_lookup.row_at(driven, begin_ns + _HELD_NS)
    held = (float(later[trajectory_lookup.ACCEL]) - accel_mps2) / (_HELD_NS * 1e-9)
    return StartState(
        pose,
        speed_mps,
        accel_mps2,
        float(row[trajectory_lookup.CURVATURE]),
        held if speed_mps > _MOVES_MPS else None,
    )


def _driven(state: MotionPlanningState) -> Trajectory | None:
    if state.stopping is not None:
        return state.stopping
    return None if state.answer is None else Trajectory(state.answer.stamp_ns, state.answer.trajectory)


def _moving_stop(state: MotionPlanningState, ego: Ego, decel_mps2: float) -> Trajectory | None:
    """The present trajectory as a stop; None without one, or when the vehicle stands."""
    driven = _driven(state)
    if driven is None or ego.speed_mps < 0.05:
        return None
    return trajectory_lookup.stopping(driven, ego.stamp_ns, decel_mps2)


def _standing(ego: Ego, reason: SpeedLimitReason, stop_m: float) -> Path:
    return Path(ego.stamp_ns, _NOWHERE, _NO_SPEEDS, 0.0, reason, None, stop_m, False)


def _ahead(trajectory: Trajectory, now_ns: int) -> np.ndarray:
    """Its rows of the next seconds."""
    since_s = (now_ns - trajectory.stamp_ns) * 1e-9
    times = trajectory.rows[:, trajectory_lookup.T]
    kept = (times >= since_s) & (times <= since_s + _AHEAD_ROWS_S)
    return trajectory.rows[kept] if kept.any() else trajectory.rows[-1:]
