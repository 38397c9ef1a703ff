"""The speed along one path: limits by place, agents on the s-t graph, the search and the program."""

from typing import NamedTuple

import msgspec
import numpy as np

from contract.geometry import Array, BoolArray
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.motion.agents import MovingDiscs, early_slots
from vehicle_agent.planning.motion.clearance import first_touch
from vehicle_agent.planning.motion.path.path_problem import Road
from vehicle_agent.planning.motion.path.path_samples import PathSamples
from vehicle_agent.planning.motion.request import MotionParams, MotionRequest
from vehicle_agent.planning.motion.speed import speed_limits, st_graph, st_search
from vehicle_agent.planning.motion.speed.occupancy import Occupancy, project_agents
from vehicle_agent.planning.motion.speed.speed_limits import PlaceLimits
from vehicle_agent.planning.motion.speed.speed_qp import (
    SpeedBounds,
    SpeedCorridor,
    SpeedPlan,
    SpeedStart,
    brake_from,
    solve_speed,
    started,
)

_PROGRAMS = 3
_FAR_M = 1e3


class SpeedSolution(msgspec.Struct, frozen=True):
    """A speed plan and its causes.

    plan         None when the program failed
    limits       by place; occupancy of the path
    yields_to, passes  rows of the request's agents
    cut_s_m      static blockage on the line, inf for none
    limited_by   as text; inside: a person or obstacle is inside the outline now
    graph, corridor  the s-t graph and the corridor through it; stop_m: way to the last place to drive to
    """

    plan: SpeedPlan | None
    limits: PlaceLimits
    occupancy: Occupancy
    yields_to: np.ndarray
    passes: np.ndarray
    cut_s_m: float
    limited_by: SpeedLimitReason
    inside: bool
    nodes: int
    graph: st_graph.StGraph
    corridor: st_graph.StCorridor
    stop_m: float


class _Stop(NamedTuple):
    """way_m to the last place that may be driven to; cut_s_m on the line, inf without static blockage;
    touching: an obstacle is inside the outline now."""

    way_m: float
    cut_s_m: float
    touching: bool


class _KnotLimits(NamedTuple):
    """Speed limits at the samples' ways u_m (n,): by place (n,), by people at each knot (K, n), and of these
    by the room to stop alone, which holds up to the next sample (`Occupancy.room_mps`)."""

    u_m: Array
    place_mps: Array
    clearance_mps: Array
    room_mps: Array


def plan_speed(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    samples: PathSamples,
    moving: MovingDiscs,
    obstacles: Array,
) -> SpeedSolution:
    """The speed for this very path; no speed of an earlier path is used."""
    limits = params.limits
    stop = _stop(params, road, samples, obstacles)
    given = np.interp(samples.s_m, road.s_m, road.speed_mps)
    cap = params.doubt_mps if len(moving.doubted) else np.inf
    v0, a0 = max(request.start.speed_mps, 0.0), request.start.accel_mps2
    place = speed_limits.place_limits(samples, given, stop.way_m, limits, params.vehicle, cap, v0)
    if v0 < 0.05:
        a0 = max(a0, 0.0)
    occupancy = project_agents(samples, moving, len(request.agents.ids), params.projection)
    graph = _graph(request, params, occupancy)
    bounds = SpeedBounds(
        limits.accel_mps2_max,
        limits.decel_mps2_comfort,
        limits.decel_mps2_max,
        limits.jerk_mps3_max,
        limits.accel_fade_1ps,
    )
    start = started(v0, a0, request.start.held_jerk_mps3, bounds, params.knot_s)
    clearance_limit, room_limit = _people_limits(params, occupancy, samples.u_m, start)
    urgency = params.speed.urgency(len(clearance_limit), params.knot_s)
    way = st_search.search(
        graph, samples.u_m, place.speed_mps, clearance_limit, v0, a0, limits, urgency, params.nodes_max
    )
    room = st_graph.corridor(graph, way.u_m)
    knot_limits = _KnotLimits(samples.u_m, place.speed_mps, clearance_limit, room_limit)
    plan = _solve(start, bounds, params, room, stop.way_m, knot_limits, way.u_m[1:])
    high = np.minimum(np.minimum(room.high_m[1:], stop.way_m), room.soft_m[1:])
    return SpeedSolution(
        plan=plan,
        limits=place,
        occupancy=occupancy,
        yields_to=room.yields_to,
        passes=room.passes,
        cut_s_m=stop.cut_s_m,
        limited_by=_limited_by(plan, place, knot_limits, high, stop),
        inside=stop.touching or bool(occupancy.inside.any()),
        nodes=way.nodes,
        graph=graph,
        corridor=room,
        stop_m=stop.way_m,
    )


def _graph(request: MotionRequest, params: MotionParams, occupancy: Occupancy) -> st_graph.StGraph:
    return st_graph.graph(
        occupancy,
        request.agents.pass_rule,
        round(params.knot_s / params.row_s),
        early_slots(request.agents, params),
        params.knot_s,
        params.stop_gap_m,
    )


def _people_limits(
    params: MotionParams, occupancy: Occupancy, u_m: Array, start: SpeedStart
) -> tuple[Array, Array]:
    """((K, n), (K, n)) the speed by people at each knot and sample, and by the room to stop alone.

    Braking with yield_mps2 is enough to keep it, and no harder braking is asked for: avoiding contact is up
    to the corridor.
    """
    limits = params.limits
    per_knot = round(params.knot_s / params.row_s)
    top_mps = max(limits.speed_mps_max, start.speed_mps) + 0.5
    lowered = speed_limits.backward_in_time(
        np.minimum(occupancy.limit_mps[::per_knot], top_mps), u_m, params.yield_mps2, params.knot_s
    )
    braking = brake_from(start, params.yield_mps2, limits.jerk_mps3_max, params.knot_s, len(lowered) - 1)
    can_mps = braking[:, 1, None]
    return np.maximum(lowered, can_mps), np.maximum(occupancy.room_mps[::per_knot], can_mps)


def _solve(
    start: SpeedStart,
    bounds: SpeedBounds,
    params: MotionParams,
    room: st_graph.StCorridor,
    stop_m: float,
    limits: _KnotLimits,
    at: Array,
) -> SpeedPlan | None:
    """The program's answer, solved again while limits at the places it reaches differ from those assumed.

    at (N,): the ways at knots 1..N that the search has found. None when the first program fails.
    """
    high = np.minimum(room.high_m[1:], stop_m)
    gap_s = np.where(room.high_m[1:] < stop_m, params.gap_s, 0.0)
    soft = np.minimum(room.soft_m[1:], _FAR_M)
    plan: SpeedPlan | None = None
    for _ in range(_PROGRAMS):
        limit, slope, is_people = _along(limits, at)
        desired, answer_s = limit.copy(), np.where(is_people, params.room.late_s, 0.0)
        _end_ahead(limit, slope, at, high, room.end_speed_mps, bounds.decel_mps2_comfort)
        limit[room.stands[1:]], slope[room.stands[1:]] = 0.0, 0.0
        corridor = SpeedCorridor(room.low_m[1:], high, gap_s, soft, at, limit, slope, answer_s, desired)
        tried = solve_speed(start, corridor, bounds, params.limits.speed_mps_max, params.speed, params.knot_s)
        if not tried.solved:
            break
        plan = tried
        at = np.clip(plan.u_m[1:], 0.0, limits.u_m[-1])
        now, _, _ = _along(limits, at)
        if (plan.v_mps[1:] - now).max() < 0.03:
            break
    return plan


def _stop(params: MotionParams, road: Road, samples: PathSamples, obstacles: Array) -> _Stop:
    end_m = min(road.end_m, road.folds_m - 2.0)
    stop_m = float(np.interp(end_m, samples.s_m, samples.u_m))
    if not len(obstacles):
        return _Stop(stop_m, np.inf, False)
    hits, touching = first_touch(samples.poses_map, params.vehicle.box, obstacles, params.static_margin_m)
    if touching or hits < 0:
        return _Stop(stop_m, np.inf, touching)
    free_m = max(float(samples.u_m[hits]) - params.stop_gap_m, 0.0)
    return _Stop(min(stop_m, free_m), float(samples.s_m[hits]), False)


def _along(limits: _KnotLimits, at: Array) -> tuple[Array, Array, BoolArray]:
    """(limit, slope, whether people set it) at the way `at` (N,) of knots 1..N: the lower limit and how it
    changes."""
    step, u, place, clearance_limit = 0.25, limits.u_m, limits.place_mps, limits.clearance_mps
    found, is_people = [], np.zeros(len(at), np.bool_)
    for query in (at, at + step):
        j = np.clip(np.searchsorted(u, query, side="right") - 1, 0, len(u) - 2)
        w = np.clip((query - u[j]) / np.maximum(u[j + 1] - u[j], 1e-9), 0.0, 1.0)
        k = np.arange(1, len(at) + 1)
        people = clearance_limit[k, j] + w * (clearance_limit[k, j + 1] - clearance_limit[k, j])
        people = np.minimum(people, limits.room_mps[k, j])
        by_place = place[j] + w * (place[j + 1] - place[j])
        is_people |= people < by_place
        found.append(np.minimum(by_place, people))
    slope = np.clip((found[1] - found[0]) / step, -1.5, 0.3)
    return found[0], slope, is_people


def _end_ahead(limit: Array, slope: Array, at: Array, high: Array, end_speed: float, decel: float) -> None:
    """Lowers the last knot's limit to what suits the agent ahead then: v^2 <= v_ahead^2 + 2 a gap."""
    gap = max(high[-1] - at[-1], 0.0)
    allowed = np.sqrt(end_speed**2 + 2.0 * decel * gap)
    if allowed < limit[-1]:
        limit[-1] = allowed
        slope[-1] = -min(decel / max(allowed, 0.3), 1.5)


def _limited_by(
    plan: SpeedPlan | None, place: PlaceLimits, limits: _KnotLimits, high: Array, stop: _Stop
) -> SpeedLimitReason:
    """The first cause along the plan that holds the vehicle back."""
    if plan is None:
        return "infeasible"
    u, clearance_limit = limits.u_m, limits.clearance_mps
    for k in range(1, len(plan.u_m)):
        j = min(int(np.searchsorted(u, plan.u_m[k])), len(u) - 1)
        if high[k - 1] < stop.way_m and plan.u_m[k] > high[k - 1] - 0.3:
            return speed_limits.CAUSES[speed_limits.YIELDING]
        if clearance_limit[k, j] < place.speed_mps[j] and plan.v_mps[k] > clearance_limit[k, j] - 0.1:
            return speed_limits.CAUSES[speed_limits.CLEARANCE]
        if plan.v_mps[k] > place.speed_mps[j] - 0.1:
            cause = int(place.cause[j])
            is_blocked = cause == speed_limits.STOP and np.isfinite(stop.cut_s_m)
            return "blocked" if is_blocked else speed_limits.CAUSES[cause]
    return "acceleration"
