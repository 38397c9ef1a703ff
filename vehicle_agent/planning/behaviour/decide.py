"""The behavioral planner: what to do, before how to move (Snow Lion, behavioral planning).

A job gives a decision: the lateral offset, speed limits by place, the road users to yield to, and where to
stop. Each plan has a new decision; what must persist is in the job's memory.
"""

import math
from typing import NamedTuple

import msgspec
import numpy as np

from contract.geometry import Array, project
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.behaviour.cleared_ground import with_cleared_ground
from vehicle_agent.planning.behaviour.crossing_traffic import CrossingRules, YieldDecision, yielding
from vehicle_agent.planning.behaviour.occlusion import (
    OcclusionRules,
    PathStations,
    Sight,
    hidden_beside,
    occlusion_speeds,
)
from vehicle_agent.planning.behaviour.offsets import (
    Blend,
    Movers,
    OffsetChoice,
    OffsetRules,
    Stations,
    choose,
    rate,
)
from vehicle_agent.planning.behaviour.scenarios import SCENARIO_RULES, ScenarioRules
from vehicle_agent.planning.motion.clearance import Box
from vehicle_agent.signals import PEDESTRIAN, Corridor, PlanJob

_CELL_RADIUS_M = 0.12
_CELL_M = 0.3
_DISC_REACH_M = 6.0
_HIDDEN_STEP_M = 0.25


class BehaviourRules(msgspec.Struct, frozen=True):
    """The behavioral planner's parameters.

    front_m, back_m, half_width_m  of the body about the rear axle; wall_m: margin to walls and kerbs
    standing_mps   a slower road user is an obstacle to drive around
    gap_m          between the bumper and an obstacle on the way
    sensor_x_m     the sensor ahead of the rear axle
    run_mps, react_s, decel_mps2  speed of a person who comes from a hidden place; how the vehicle can stop
    creep_mps      hidden places do not lower the speed below this
    inflation_growth, inflation_m_max  share of a prediction's deviation that is added to the inflation
    """

    front_m: float
    back_m: float
    half_width_m: float
    crossing: CrossingRules
    offsets: OffsetRules = OffsetRules()
    wall_m: float = 0.1
    standing_mps: float = 0.25
    gap_m: float = 1.0
    sensor_x_m: float = 3.2
    run_mps: float = 2.6
    react_s: float = 0.6
    decel_mps2: float = 5.0
    creep_mps: float = 1.0
    hidden_reach_m: float = 3.0
    inflation_growth: float = 0.5
    inflation_m_max: float = 0.5

    @property
    def box(self) -> Box:
        return Box(self.front_m, self.back_m, self.half_width_m)

    @property
    def occlusion(self) -> OcclusionRules:
        return OcclusionRules(
            self.front_m,
            self.front_m - self.sensor_x_m,
            self.half_width_m,
            self.run_mps,
            self.react_s,
            self.decel_mps2,
            self.creep_mps,
        )


class Decision(msgspec.Struct, frozen=True):
    """One decision; arrays (n,) by station of the job's corridor, at stations_m.

    s_m, l_m  the start on the line
    end_s_m   where the rear axle stops at the latest, and end_reason
    cut_s_m   where a stationary obstacle blocks the way, inf for nowhere
    discs     (m, 3) stationary obstacles; inflation_m (a, k) of the job's predictions
    """

    s_m: float
    l_m: float
    stations_m: np.ndarray
    reference_l_m: np.ndarray
    lower_l_m: np.ndarray
    upper_l_m: np.ndarray
    speed_mps_max: np.ndarray
    reasons: tuple[SpeedLimitReason, ...]
    end_s_m: float
    end_reason: SpeedLimitReason
    cut_s_m: float
    discs: np.ndarray
    inflation_m: np.ndarray
    chosen: OffsetChoice
    yielding: YieldDecision


def decide(job: PlanJob, rules: BehaviourRules) -> Decision:
    """One decision. The job's corridor must have stations around the start."""
    corridor = job.corridor
    start = _start(job)
    scenario = SCENARIO_RULES[int(corridor.scenario[start.station])]
    upper = np.maximum(corridor.left_m - rules.half_width_m - rules.wall_m, 0.0)
    lower = -np.maximum(corridor.right_m - rules.half_width_m - rules.wall_m, 0.0)
    discs = standing_discs(job, rules)
    candidates = np.array(scenario.offsets_m)
    ratings = _rated(job, rules, scenario, candidates, discs, (lower, upper), start)
    memory = job.memory
    chosen = choose(
        rules.offsets,
        candidates,
        ratings,
        memory.offset_m,
        memory.better_offset_m,
        memory.better_count,
    )
    reference = np.clip(np.full(len(corridor.s_m), chosen.offset_m), lower, upper)
    yields = yielding(job, start.s_m, rules.crossing)
    speeds, reasons = _speeds(job, rules, reference, discs, yields, start.station)
    cut_s_m, end_s_m, end_reason = _end(job, rules, chosen, yields, start.s_m)
    return Decision(
        s_m=start.s_m,
        l_m=start.l_m,
        stations_m=corridor.s_m,
        reference_l_m=reference,
        lower_l_m=lower,
        upper_l_m=upper,
        speed_mps_max=speeds,
        reasons=reasons,
        end_s_m=end_s_m,
        end_reason=end_reason,
        cut_s_m=cut_s_m,
        discs=discs,
        inflation_m=_inflation(job, rules, scenario),
        chosen=chosen,
        yielding=yields,
    )


class _Start(NamedTuple):
    """Where the job's start is on its corridor: s_m, l_m, and the station before it."""

    s_m: float
    l_m: float
    station: int


def _start(job: PlanJob) -> _Start:
    corridor, pose = job.corridor, job.pose_map
    along_m, l_m, first = project(
        corridor.points_map,
        corridor.s_m - corridor.s_m[0],
        pose.x_m,
        pose.y_m,
        0,
        len(corridor.s_m) - 1,
    )
    return _Start(float(corridor.s_m[0] + along_m), float(l_m), int(first))


def _end(
    job: PlanJob, rules: BehaviourRules, chosen: OffsetChoice, yields: YieldDecision, s_m: float
) -> tuple[float, float, SpeedLimitReason]:
    """(where the way is blocked, inf for nowhere; where the rear axle stops at the latest; why)."""
    # The way is free up to the station before the one at which the body touches.
    free_m = max(0.0, chosen.free_m - rules.offsets.step_m)
    cut_s_m = s_m + free_m if math.isfinite(free_m) else math.inf
    end_s_m, end_reason = min(
        (job.stop_s_m, job.stop_reason),
        (yields.end_s_m, "crossing_traffic"),
        (max(s_m, cut_s_m - rules.gap_m), "obstacle"),
    )
    return cut_s_m, end_s_m, end_reason


def standing_discs(job: PlanJob, rules: BehaviourRules) -> Array:
    """(m, 3) obstacle cells, one a few decimetres, and standing tracks; a box is discs along its outline."""
    low = job.corridor.points_map.min(axis=0) - _DISC_REACH_M
    high = job.corridor.points_map.max(axis=0) + _DISC_REACH_M
    points = job.points_map
    points = points[((low <= points) & (points <= high)).all(axis=1)]
    if len(points):
        _, kept = np.unique(np.round(points / _CELL_M).astype(np.int64), axis=0, return_index=True)
        points = points[np.sort(kept)]
    pieces = [np.column_stack((points, np.full(len(points), _CELL_RADIUS_M)))]
    speeds = np.hypot(job.tracks.velocities_map_mps[:, 0], job.tracks.velocities_map_mps[:, 1])
    for i in np.flatnonzero(speeds < rules.standing_mps):
        pose, size = job.tracks.poses_map[i], job.tracks.sizes_m[i]
        if job.tracks.kinds[i] == PEDESTRIAN:
            pieces.append(np.array([[pose[0], pose[1], 0.5 * size[0]]]))
        else:
            pieces.append(_outline_discs(pose, size))
    discs: Array = np.ascontiguousarray(np.vstack(pieces))
    return discs


def _outline_discs(pose: Array, size: Array) -> Array:
    """Discs of 0.2 m along the inside of a box's outline, half a metre apart."""
    u, v = max(0.5 * size[0] - 0.2, 0.0), max(0.5 * size[1] - 0.2, 0.0)
    along = np.linspace(-u, u, max(2, math.ceil(4.0 * u)))
    aside = np.linspace(-v, v, max(2, math.ceil(4.0 * v)))
    rim = np.vstack(
        (
            np.column_stack((along, np.full(len(along), v))),
            np.column_stack((along, np.full(len(along), -v))),
            np.column_stack((np.full(len(aside), u), aside)),
            np.column_stack((np.full(len(aside), -u), aside)),
        )
    )
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return np.column_stack(
        (
            pose[0] + cos * rim[:, 0] - sin * rim[:, 1],
            pose[1] + sin * rim[:, 0] + cos * rim[:, 1],
            np.full(len(rim), 0.2),
        )
    )


def _rated(
    job: PlanJob,
    rules: BehaviourRules,
    scenario: ScenarioRules,
    candidates: Array,
    discs: Array,
    walls: tuple[Array, Array],
    start: _Start,
) -> Array:
    """(c, 5) ratings of the candidate offsets; walls: (lower, upper) (n,) by station."""
    corridor, offsets, first = job.corridor, rules.offsets, start.station
    step_m = float(corridor.s_m[1] - corridor.s_m[0])
    turned = math.remainder(job.pose_map.yaw_rad - float(corridor.yaw_rad[first]), math.tau)
    slope = math.tan(min(max(turned, -0.8), 0.8)) * (1.0 - float(corridor.curvature_1pm[first]) * start.l_m)
    stations = Stations(
        points=corridor.points_map,
        yaws=corridor.yaw_rad,
        curvatures=corridor.curvature_1pm,
        lower=walls[0],
        upper=walls[1],
        step_m=step_m,
        first=first,
        last=min(len(corridor.s_m) - 1, first + math.floor(offsets.look_m / step_m)),
        stride=max(1, round(offsets.step_m / step_m)),
    )
    blend = Blend(start.l_m, slope, offsets.blend_m + offsets.blend_s * job.speed_mps)
    speed_mps = min(max(job.speed_mps, 1.5), max(job.speed_mps_max, 0.1))
    moving = _moving(job, rules, scenario)
    return rate(stations, candidates, blend, speed_mps, discs, moving, rules.box, offsets)


def _moving(job: PlanJob, rules: BehaviourRules, scenario: ScenarioRules) -> Movers:
    """The moving road users where they are predicted to be after the job's start."""
    tracks, predictions, offsets = job.tracks, job.predictions, rules.offsets
    moves = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1]) >= rules.standing_mps
    late_s = (job.stamp_ns - predictions.stamp_ns) * 1e-9 if predictions.stamp_ns else 0.0
    times_s = offsets.moving_step_s * np.arange(1, math.floor(offsets.moving_s / offsets.moving_step_s) + 1)
    nearest = np.searchsorted(predictions.times_s, times_s + late_s - 1e-6)
    after = np.clip(nearest, 1, max(len(predictions.times_s) - 1, 1))
    if len(predictions.times_s) < 2:
        poses = np.repeat(predictions.poses_map[moves, :1], len(times_s), axis=1)
        return Movers(poses, tracks.sizes_m[moves], np.full(poses.shape[:2], scenario.inflation_m))
    begin_s, end_s = predictions.times_s[after - 1], predictions.times_s[after]
    share = np.clip((times_s + late_s - begin_s) / (end_s - begin_s), 0.0, 1.0)[None, :, None]
    known = predictions.poses_map[moves]
    poses = known[:, after].copy()
    poses[:, :, :2] = (1.0 - share) * known[:, after - 1, :2] + share * known[:, after, :2]
    wider = _inflation(job, rules, scenario)[moves][:, after]
    return Movers(
        np.ascontiguousarray(poses), np.ascontiguousarray(tracks.sizes_m[moves]), np.ascontiguousarray(wider)
    )


def _speeds(
    job: PlanJob,
    rules: BehaviourRules,
    reference: Array,
    discs: Array,
    yields: YieldDecision,
    first: int,
) -> tuple[Array, tuple[SpeedLimitReason, ...]]:
    """(n,) the lowest limit by station, and the reason of each."""
    corridor: Corridor = job.corridor
    scenario_mps = np.array([rule.speed_mps_max for rule in SCENARIO_RULES])
    slow = np.full(len(corridor.s_m), np.inf)
    for from_s_m, to_s_m, speed_mps in yields.slow:
        held = (corridor.s_m >= from_s_m) & (corridor.s_m <= to_s_m)
        slow[held] = np.minimum(slow[held], speed_mps)
    layers: tuple[tuple[SpeedLimitReason, Array], ...] = (
        ("speed_limit", corridor.limit_mps),
        (job.speed_reason, np.full(len(corridor.s_m), job.speed_mps_max)),
        ("scenario", scenario_mps[corridor.scenario]),
        ("crossing", slow),
        ("occlusion", _occlusion_limits(job, rules, reference, discs, first)),
    )
    table = np.vstack([limits for _, limits in layers])
    lowest = np.argmin(table, axis=0)
    speeds: Array = table.min(axis=0)
    return speeds, tuple(layers[i][0] for i in lowest)


def _occlusion_limits(
    job: PlanJob, rules: BehaviourRules, reference: Array, discs: Array, first: int
) -> Array:
    """(n,) the speed limit past places that the vehicle cannot see into."""
    corridor, view = job.corridor, job.view.pose_map
    step_m = float(corridor.s_m[1] - corridor.s_m[0])
    front = first + math.ceil(rules.front_m / step_m)
    path = PathStations(
        corridor.points_map, corridor.yaw_rad, reference, front, front + math.ceil(25.0 / step_m)
    )
    sight = Sight(view.x_m, view.y_m, view.yaw_rad, job.view.ranges_m)
    solid = np.ascontiguousarray(discs[:, :2])
    hidden = hidden_beside(path, sight, solid, rules.half_width_m, rules.hidden_reach_m, _HIDDEN_STEP_M)
    if any(area.clear_ns for area in job.watched):
        hidden = with_cleared_ground(
            hidden,
            path,
            job.watched,
            job.stamp_ns,
            rules.half_width_m,
            rules.hidden_reach_m,
            _HIDDEN_STEP_M,
            rules.run_mps,
        )
    limits: Array = occlusion_speeds(hidden, step_m, max(job.speed_mps_max, 0.1), rules.occlusion)
    return limits


def _inflation(job: PlanJob, rules: BehaviourRules, scenario: ScenarioRules) -> Array:
    """(a, k) w_o of the scenario, and a share of the growth of each prediction's deviation."""
    growth = rules.inflation_growth * (job.predictions.sigmas_m - job.predictions.sigmas_m[:, :1])
    inflation: Array = np.minimum(scenario.inflation_m + growth, rules.inflation_m_max)
    return inflation
