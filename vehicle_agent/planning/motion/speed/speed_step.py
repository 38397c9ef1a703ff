"""The speed along one path: limits by place, agents on the s-t graph, who goes first, and the program."""

import msgspec
import numpy as np

from contract.geometry import Array
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
    brake_from,
    solve_speed,
    started,
)

_PROGRAMS = 3
_FAR_M = 1e3


class SpeedSolution(msgspec.Struct, frozen=True):
    """A speed plan and what shaped it.

    plan         None when the program failed
    limits       by place; occupancy of the path
    yields_to, passes  rows of the request's agents
    cut_s_m      static blockage on the line, inf for none
    limited_by   in words; inside: somebody or something is inside the outline now
    """

    plan: SpeedPlan | None
    limits: PlaceLimits
    occupancy: Occupancy
    yields_to: np.ndarray
    passes: np.ndarray
    cut_s_m: float
    limited_by: str
    inside: bool
    nodes: int


def plan_speed(
    request: MotionRequest,
    params: MotionParams,
    road: Road,
    samples: PathSamples,
    moving: MovingDiscs,
    obstacles: Array,
) -> SpeedSolution:
    """The speed for this very path; nothing of an earlier path's speed is kept."""
    limits, box = params.limits, params.vehicle.box
    stop_m, cut_s_m, touching = _stop(params, road, samples, obstacles)
    given = np.interp(samples.s_m, road.s_m, road.speed_mps)
    cap = params.doubt_mps if len(moving.doubted) else np.inf
    place = speed_limits.place_limits(
        samples, given, stop_m, limits, params.vehicle, cap, max(request.start.speed_mps, 0.0)
    )
    occupancy = project_agents(
        samples,
        moving,
        len(request.agents.ids),
        box,
        params.hard_margin_m,
        params.soft_margin_m,
        params.law,
        params.vehicle.nose_m,
        params.room,
    )
    per_knot = round(params.knot_s / params.row_s)
    graph = st_graph.graph(
        occupancy,
        request.agents.pass_rule,
        per_knot,
        early_slots(request.agents, params),
        params.knot_s,
        params.stop_gap_m,
    )
    v0, a0 = max(request.start.speed_mps, 0.0), request.start.accel_mps2
    if v0 < 0.05:
        a0 = max(a0, 0.0)
    bounds = SpeedBounds(
        limits.accel_mps2_max, limits.decel_mps2_comfort, limits.decel_mps2_max, limits.jerk_mps3_max
    )
    start = started(v0, a0, request.start.held_jerk_mps3, bounds, params.knot_s)
    top_mps = max(limits.speed_mps_max, v0) + 0.5
    clearance_limit = speed_limits.backward_in_time(
        np.minimum(occupancy.limit_mps[::per_knot], top_mps),
        samples.u_m,
        limits.decel_mps2_comfort,
        params.knot_s,
    )
    knots = len(clearance_limit) - 1
    braking = brake_from(start, limits.decel_mps2_comfort, limits.jerk_mps3_max, params.knot_s, knots)
    # A clearance is kept by braking comfortably and no harder: contact is the corridor's matter.
    clearance_limit = np.maximum(clearance_limit, braking[:, 1, None])
    way = st_search.search(
        graph, samples.u_m, place.speed_mps, clearance_limit, v0, a0, limits, params.nodes_max
    )
    room = st_graph.corridor(graph, way.u_m)
    high = np.minimum(room.high_m[1:], stop_m)
    gap_s = np.where(room.high_m[1:] < stop_m, params.gap_s, 0.0)
    plan: SpeedPlan | None = None
    at = way.u_m[1:]
    for _ in range(_PROGRAMS):
        limit, slope, wish = _along(samples.u_m, place.speed_mps, clearance_limit, at)
        _end_ahead(limit, slope, at, high, room.end_speed_mps, limits.decel_mps2_comfort)
        limit[room.stands[1:]], slope[room.stands[1:]] = 0.0, 0.0
        corridor = SpeedCorridor(
            room.low_m[1:], high, gap_s, np.minimum(room.soft_m[1:], _FAR_M), at, limit, slope, wish
        )
        tried = solve_speed(start, corridor, bounds, limits.speed_mps_max, params.speed, params.knot_s)
        if not tried.solved:
            break
        plan = tried
        at = np.clip(plan.u_m[1:], 0.0, samples.u_m[-1])
        now, _, _ = _along(samples.u_m, place.speed_mps, clearance_limit, at)
        if (plan.v_mps[1:] - now).max() < 0.03:
            break
    inside = touching or bool(occupancy.inside.any())
    return SpeedSolution(
        plan,
        place,
        occupancy,
        room.yields_to,
        room.passes,
        cut_s_m,
        _limited_by(
            plan, place, samples.u_m, clearance_limit, np.minimum(high, room.soft_m[1:]), stop_m, cut_s_m
        ),
        inside,
        way.nodes,
    )


def _stop(
    params: MotionParams, road: Road, samples: PathSamples, obstacles: Array
) -> tuple[float, float, bool]:
    """(way to the last place that may be driven to, cut on the line, whether something touches now)."""
    end_m = min(road.end_m, road.folds_m - 2.0)
    stop_m = float(np.interp(end_m, samples.s_m, samples.u_m))
    if not len(obstacles):
        return stop_m, np.inf, False
    box = params.vehicle.box
    hits, touching = first_touch(
        samples.poses_map, box.front_m, box.rear_m, box.half_width_m, obstacles, params.static_margin_m
    )
    if touching or hits < 0:
        return stop_m, np.inf, touching
    cut_s_m = float(samples.s_m[hits])
    return min(stop_m, max(float(samples.u_m[hits]) - params.stop_gap_m, 0.0)), cut_s_m, False


def _along(u: Array, place: Array, clearance_limit: Array, at: Array) -> tuple[Array, Array, Array]:
    """(limit, slope, wish) at the way `at` (N,) of knots 1..N: the lower limit and how it changes."""
    step = 0.25
    limits = []
    for query in (at, at + step):
        j = np.clip(np.searchsorted(u, query, side="right") - 1, 0, len(u) - 2)
        w = np.clip((query - u[j]) / (u[j + 1] - u[j]), 0.0, 1.0)
        k = np.arange(1, len(at) + 1)
        people = clearance_limit[k, j] + w * (clearance_limit[k, j + 1] - clearance_limit[k, j])
        limits.append(np.minimum(place[j] + w * (place[j + 1] - place[j]), people))
    slope = np.clip((limits[1] - limits[0]) / step, -1.5, 0.3)
    return limits[0], slope, limits[0].copy()


def _end_ahead(limit: Array, slope: Array, at: Array, high: Array, end_speed: float, decel: float) -> None:
    """At the last knot: slow enough for whoever is ahead then (v^2 <= v_ahead^2 + 2 a gap), in place."""
    gap = max(high[-1] - at[-1], 0.0)
    allowed = np.sqrt(end_speed**2 + 2.0 * decel * gap)
    if allowed < limit[-1]:
        limit[-1] = allowed
        slope[-1] = -min(decel / max(allowed, 0.3), 1.5)


def _limited_by(
    plan: SpeedPlan | None,
    place: PlaceLimits,
    u: Array,
    clearance_limit: Array,
    high: Array,
    stop_m: float,
    cut_s_m: float,
) -> str:
    """The first thing along the plan that holds the vehicle back."""
    if plan is None:
        return "no speed"
    for k in range(1, len(plan.u_m)):
        j = min(int(np.searchsorted(u, plan.u_m[k])), len(u) - 1)
        if high[k - 1] < stop_m and plan.u_m[k] > high[k - 1] - 0.3:
            return speed_limits.CAUSES[speed_limits.YIELDING]
        if clearance_limit[k, j] < place.speed_mps[j] and plan.v_mps[k] > clearance_limit[k, j] - 0.1:
            return speed_limits.CAUSES[speed_limits.CLEARANCE]
        if plan.v_mps[k] > place.speed_mps[j] - 0.1:
            cause = int(place.cause[j])
            return (
                "blocked"
                if cause == speed_limits.STOP and np.isfinite(cut_s_m)
                else speed_limits.CAUSES[cause]
            )
    return "acceleration"
