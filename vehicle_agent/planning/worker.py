"""The motion planner that answers jobs: first what to do, then how to move."""

import numpy as np

from contract.geometry import Array
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.behaviour.decide import BehaviourRules, Decision, decide
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import (
    PASS_FREE,
    PASS_YIELD,
    Agents,
    Motion,
    MotionParams,
    MotionRequest,
    StartState,
    WarmStart,
)
from vehicle_agent.signals import PlanAnswer, PlanJob, PlanMemory


class MotionPlanner:
    """Answers one job at a time and remembers nothing: equal jobs give equal answers."""

    def __init__(self, rules: BehaviourRules, params: MotionParams) -> None:
        self._rules = rules
        self._params = params

    def __call__(self, job: PlanJob) -> PlanAnswer:
        decision = decide(job, self._rules)
        motion = plan_motion(_request(job, decision, self._rules), self._params)
        return _answer(job, decision, motion)


def _request(job: PlanJob, decision: Decision, rules: BehaviourRules) -> MotionRequest:
    memory = job.memory
    warm = WarmStart(memory.path_s_m, memory.path_l_m) if len(memory.path_s_m) else None
    return MotionRequest(
        corridor=job.corridor,
        start=StartState(job.pose_map, job.speed_mps, job.accel_mps2, job.curvature_1pm, job.held_jerk_mps3),
        reference_l_m=decision.reference_l_m,
        lower_l_m=decision.lower_l_m,
        upper_l_m=decision.upper_l_m,
        speed_mps_max=decision.speed_mps_max,
        end_s_m=decision.end_s_m,
        static_discs=decision.discs,
        agents=_agents(job, decision, rules),
        warm=warm,
        s_hint_m=decision.s_m,
        speed_reasons=decision.reasons,
    )


def _agents(job: PlanJob, decision: Decision, rules: BehaviourRules) -> Agents:
    """The predictions from the job's own moment on."""
    tracks, predictions = job.tracks, job.predictions
    late_s = (job.stamp_ns - predictions.stamp_ns) * 1e-9 if predictions.stamp_ns else 0.0
    times_s = predictions.times_s - late_s
    first = max(0, int(np.searchsorted(times_s, 0.0, side="right")) - 1)
    yields = np.isin(tracks.ids, np.array(decision.yielding.to, dtype=np.int64))
    poses = predictions.poses_map[:, first:].copy()
    if first < len(times_s) - 1 and len(poses):
        # The first column is moved to the job's moment itself, so that times begin at 0.
        share = -times_s[first] / (times_s[first + 1] - times_s[first])
        poses[:, 0] += share * (poses[:, 1] - poses[:, 0])
    times: Array = times_s[first:].copy()
    times[0] = 0.0
    return Agents(
        ids=tracks.ids,
        kinds=tracks.kinds,
        times_s=times,
        poses_map=np.ascontiguousarray(poses),
        sizes_m=tracks.sizes_m,
        inflation_m=np.ascontiguousarray(decision.inflation_m[:, first:]),
        pass_rule=np.where(yields, PASS_YIELD, PASS_FREE).astype(np.int64),
    )


# The slowest place within this many stations ahead gives the reason for a limit.
_LOOK_STATIONS = 20
# The motion planner's words for what behaviour knows more of, and for people in the way.
_BY_PLACE: SpeedLimitReason = "speed_limit"
_AT_END: SpeedLimitReason = "stop"
_FOR_PEOPLE: frozenset[SpeedLimitReason] = frozenset({"yielding", "footprint", "blocked", "emergency"})


def _reason(decision: Decision, motion: Motion) -> SpeedLimitReason:
    """What keeps the vehicle from going faster, as the behavioral planner names it where it caused it."""
    if motion.limited_by in _FOR_PEOPLE:
        return "obstacle"
    if motion.limited_by == _AT_END and motion.quality == "planned":
        return decision.end_reason
    if motion.limited_by == _BY_PLACE:
        ahead = int(np.searchsorted(decision.stations_m, decision.s_m))
        slowest = ahead + int(np.argmin(decision.speed_mps_max[ahead : ahead + _LOOK_STATIONS]))
        return decision.reasons[slowest]
    return motion.limited_by


def _answer(job: PlanJob, decision: Decision, motion: Motion) -> PlanAnswer:
    limited_by = _reason(decision, motion)
    path = motion.path
    memory = PlanMemory(
        offset_m=decision.chosen.offset_m,
        better_offset_m=decision.chosen.better_offset_m,
        better_count=decision.chosen.better_count,
        path_s_m=path.s_m if path is not None else np.empty(0),
        path_l_m=path.states if path is not None else np.empty((0, 3)),
        stopping_for=decision.yielding.stopping_for,
    )
    return PlanAnswer(
        number=job.number,
        stamp_ns=job.stamp_ns,
        line_id=job.line_id,
        trajectory=motion.rows,
        limited_by=limited_by,
        cut_s_m=min(motion.cut_s_m, decision.cut_s_m),
        yields_to=motion.yields_to,
        violations=motion.violations,
        memory=memory,
        graph=motion.graph,
    )
