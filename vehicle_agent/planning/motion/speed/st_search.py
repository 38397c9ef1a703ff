"""Passing order by a breadth-first search on the s-t graph (Snow Lion, "Motion planning").

Layers are time slots and a node is (u, v, a). Each cell of u and v keeps only its cheapest node. The result
is a corridor for the speed program: which agents the vehicle yields to and which it passes before.
"""

import math
from typing import NamedTuple

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from vehicle_agent.planning.motion.request import DrivingLimits
from vehicle_agent.planning.motion.speed.st_graph import StGraph

_CELL_M, _CELL_MPS = 0.4, 0.25
_STILL_MPS = 0.05
# Columns of a node.
_U, _V, _A, _COST = range(4)


class StSearchResult(msgspec.Struct, frozen=True):
    """u_m, v_mps (K,) at the knots; nodes used; whether a way to the end was found."""

    u_m: np.ndarray
    v_mps: np.ndarray
    nodes: int
    found: bool


class SearchGrid(NamedTuple):
    """The s-t graph as cells of spacing_m; a knot every dt_s.

    penalty    (K, cells) cost per second of being there: inf in an occupied cell
    limit_mps  (K, cells) the speed that is allowed there
    urgency    (K,) what a second below the desired speed costs then, relative to one far ahead
    """

    penalty: Array
    limit_mps: Array
    urgency: Array
    spacing_m: float
    dt_s: float


class SearchMotion(NamedTuple):
    """The accelerations (c,) to choose from, the hardest braking first, and what bounds and prices them.

    fade_1pmps  by so much of itself an acceleration falls for each 1 m/s; it is `accels_mps2` at rest
    """

    accels_mps2: Array
    fade_1pmps: float
    jerk_mps3_max: float
    decel_mps2_comfort: float
    decel_mps2_max: float


class _Bounds(NamedTuple):
    """jerk (m/s3); comfortable and hardest deceleration, positive; the hardest braking to choose (m/s2)."""

    jerk: float
    decel: float
    decel_max: float
    hardest: float


def search(
    graph: StGraph,
    place_u_m: Array,
    place_limit_mps: Array,
    clearance_limit_mps: Array,
    v0_mps: float,
    a0_mps2: float,
    limits: DrivingLimits,
    urgency: Array,
    nodes_max: int,
) -> StSearchResult:
    """The cheapest way through the graph from u = 0 with v0, a0.

    place_u_m, place_limit_mps (n,); clearance_limit_mps (K, n); urgency (K,) as in `SearchGrid`. Standing is
    allowed anywhere: a vehicle at rest does not hit a person who walks into it.
    """
    spacing = _CELL_M
    cells = max(2, math.ceil(place_u_m[-1] / spacing) + 1)
    at = np.minimum(np.searchsorted(place_u_m, spacing * np.arange(cells)), len(place_u_m) - 1)
    limit = np.minimum(place_limit_mps[at][None, :], clearance_limit_mps[:, at])
    penalty = raster(graph.low_m, graph.high_m, graph.soft_low_m, graph.soft_high_m, cells, spacing)
    choices = np.array([-1.0, -0.7, -0.45, -0.2])
    accels = np.concatenate(
        [choices * limits.decel_mps2_max, [0.0, 0.5 * limits.accel_mps2_max, limits.accel_mps2_max]]
    )
    grid = SearchGrid(penalty, np.ascontiguousarray(limit), urgency, spacing, graph.dt_s)
    fade_1pmps = limits.accel_fade_1ps / limits.accel_mps2_max
    motion = SearchMotion(
        accels, fade_1pmps, limits.jerk_mps3_max, limits.decel_mps2_comfort, limits.decel_mps2_max
    )
    u, v, nodes, found = search_kernel(grid, motion, v0_mps, a0_mps2, nodes_max)
    return StSearchResult(u, v, nodes, found)


@njit(cache=True)
def raster(low: Array, high: Array, soft_low: Array, soft_high: Array, cells: int, spacing: float) -> Array:
    """(K, cells) cost per second of being there: inf in an occupied cell, 2 in a soft one."""
    knots, agents = low.shape
    out = np.zeros((knots, cells))
    for k in range(knots):
        for a in range(agents):
            if soft_low[k, a] <= soft_high[k, a]:
                first = max(0, math.ceil(soft_low[k, a] / spacing))
                last = min(cells - 1.0, math.floor(soft_high[k, a] / spacing))
                for c in range(first, int(last) + 1):
                    out[k, c] = max(out[k, c], 2.0)
            if low[k, a] <= high[k, a]:
                first = max(0, math.ceil(low[k, a] / spacing))
                last = min(cells - 1.0, math.floor(high[k, a] / spacing))
                for c in range(first, int(last) + 1):
                    out[k, c] = np.inf
    return out


@njit(cache=True)
def search_kernel(
    grid: SearchGrid, motion: SearchMotion, v0: float, a0: float, nodes_max: int
) -> tuple[Array, Array, int, bool]:
    """((K,) u, (K,) v, nodes, found); a layer every second knot, costs counted at every knot."""
    knots, cells = grid.penalty.shape
    layers = (knots - 1) // 2
    top = np.max(grid.limit_mps[0]) + 1.0
    speeds = int(max(v0, top) / _CELL_MPS) + 3
    nodes, parent = np.empty((nodes_max, 4)), np.full(nodes_max, -1, np.int64)
    begin = np.zeros(layers + 2, np.int64)
    nodes[0, _U], nodes[0, _V], nodes[0, _A], nodes[0, _COST] = 0.0, v0, a0, 0.0
    count = 1
    begin[1] = 1
    at = np.full((cells, speeds), -1, np.int64)
    reached = 0
    for layer in range(layers):
        at[:] = -1
        reach = (begin[layer], begin[layer + 1])
        count = _expand(grid, motion, layer, reach, nodes, parent, at, count)
        begin[layer + 2] = count
        if begin[layer + 2] == begin[layer + 1]:
            break
        reached = layer + 1
    best = begin[reached]
    for i in range(begin[reached], begin[reached + 1]):
        if nodes[i, _COST] < nodes[best, _COST]:
            best = i
    u, v = _way_to(best, reached, nodes, parent, knots, grid.dt_s)
    return u, v, count, reached == layers


@njit(cache=True)
def _expand(
    grid: SearchGrid,
    motion: SearchMotion,
    layer: int,
    members: tuple[int, int],
    nodes: Array,
    parent: IntArray,
    at: IntArray,
    count: int,
) -> int:
    """Adds the successors of a layer's nodes [first, last) to the next; returns the number of nodes then.

    at (cells, speeds): the node of the next layer in each cell, -1 for none. Arrays are taken out of the
    tuples once: each use of a tuple counts references to all of its arrays.
    """
    penalty, limit, urgency, accels = grid.penalty, grid.limit_mps, grid.urgency, motion.accels_mps2
    end = penalty.shape[1] - 1
    is_last = layer == (penalty.shape[0] - 1) // 2 - 1
    bounds = _Bounds(motion.jerk_mps3_max, motion.decel_mps2_comfort, motion.decel_mps2_max, accels[0])
    for i in range(members[0], members[1]):
        u0, v0, a0 = nodes[i, _U], nodes[i, _V], nodes[i, _A]
        for c in range(accels.shape[0]):
            a = accels[c]
            if a > 0.0:
                a *= max(1.0 - motion.fade_1pmps * v0, 0.0)
            if not _can_follow(a, a0, v0, bounds, grid.dt_s):
                continue
            u, v, cost = u0, v0, nodes[i, _COST] + 0.03 * (a - a0) ** 2
            for sub in range(2):
                k = 2 * layer + 1 + sub
                u, v = _after_one_knot(u, v, a, grid.dt_s)
                cell, share = _cell_at(u, grid.spacing_m, end)
                if share > 1.0:
                    cost = np.inf
                    break
                here = max(
                    penalty[k, cell] if share < 1.0 else 0.0, penalty[k, cell + 1] if share > 0.0 else 0.0
                )
                limits = (limit[k, cell], limit[k, cell + 1])
                cost = _with_motion_cost(cost, here, limits, share, v, a, bounds, urgency[k], grid.dt_s)
                if cost == np.inf:
                    break
            if is_last and cost < np.inf:
                cost = _with_end_cost(penalty, u, v, cost, bounds, grid.spacing_m)
            if cost == np.inf:
                continue
            iu, iv = int(u / grid.spacing_m), int(v / _CELL_MPS + 0.5)
            if iu >= at.shape[0] or iv >= at.shape[1]:
                continue
            kept = at[iu, iv]
            if kept < 0:
                if count == nodes.shape[0]:
                    continue
                kept = at[iu, iv] = count
                count += 1
            elif cost >= nodes[kept, _COST]:
                continue
            nodes[kept, _U], nodes[kept, _V], nodes[kept, _A], nodes[kept, _COST] = u, v, a, cost
            parent[kept] = i
    return count


@njit(cache=True)
def _can_follow(a: float, a_before: float, v: float, bounds: _Bounds, dt: float) -> bool:
    """The jerk allows `a` after a_before, or it is the hardest braking; a vehicle at rest does not brake."""
    if abs(a - a_before) > 2.6 * bounds.jerk * dt and not (a == bounds.hardest and a > a_before):
        return False
    return not (v <= 0.0 and a < 0.0)


@njit(cache=True)
def _after_one_knot(u: float, v: float, a: float, dt: float) -> tuple[float, float]:
    """(u, v) after dt at a constant acceleration; a vehicle that brakes to rest stays where it stops."""
    after = max(v + a * dt, 0.0)
    if after > 0.0 or a >= 0.0:
        return u + 0.5 * (v + after) * dt, after
    return u + 0.5 * v * v / -a, after


@njit(cache=True)
def _cell_at(u: float, spacing: float, end: int) -> tuple[int, float]:
    """(cell, share of the way to the next one) of a place; a share above 1 beyond the last cell `end`."""
    cell = int(u / spacing)
    if cell >= end:
        if u > end * spacing:
            return end - 1, 2.0
        cell = end - 1
    return cell, min(max(u / spacing - cell, 0.0), 1.0)


@njit(cache=True)
def _with_motion_cost(
    cost: float,
    here: float,
    limits: tuple[float, float],
    share: float,
    v: float,
    a: float,
    bounds: _Bounds,
    urgency: float,
    dt: float,
) -> float:
    """cost and that of dt at v, a in a place that costs `here` a second; inf if it is occupied.

    limits: the speeds allowed in its cell and in the next, `share` of the way to which it is
    """
    allowed = limits[0] + share * (limits[1] - limits[0])
    if here == np.inf:
        if v > _STILL_MPS:
            return np.inf
        here = 2.0
    desired = max(limits[0], 0.5)
    over = max(v - allowed, 0.0)
    cost += dt * (here + urgency * (desired - v) ** 2 + 20.0 * over * over + 4.0 * over)
    if a < 0.0:
        cost += dt * (0.4 * a * a + 2.0 * max(-a - bounds.decel, 0.0))
    else:
        cost += dt * 0.4 * a * a
    return cost


@njit(cache=True)
def _with_end_cost(penalty: Array, u: float, v: float, cost: float, bounds: _Bounds, spacing: float) -> float:
    """cost and that of stopping for an agent who is in the way at the last knot; inf if it cannot stop."""
    last, cells = penalty.shape[0] - 1, penalty.shape[1]
    cell = math.ceil(u / spacing)
    while cell < cells and penalty[last, cell] != np.inf:
        cell += 1
    gap = max(cell * spacing - u, 0.0)
    if v * v > 2.0 * bounds.decel_max * gap:
        return np.inf
    return cost + max(v * v / (2.0 * max(gap, 0.1)) - bounds.decel, 0.0) * 4.0


@njit(cache=True)
def _way_to(
    best: int, reached: int, nodes: Array, parent: IntArray, knots: int, dt: float
) -> tuple[Array, Array]:
    """((K,) u, (K,) v) of the way that ends at node `best` of layer `reached`; at rest beyond it."""
    u, v = np.empty(knots), np.empty(knots)
    for layer in range(reached, -1, -1):
        u[2 * layer], v[2 * layer] = nodes[best, _U], nodes[best, _V]
        if layer:
            before = parent[best]
            # The knot between two layers, by the same constant acceleration.
            between = _after_one_knot(nodes[before, _U], nodes[before, _V], nodes[best, _A], dt)
            u[2 * layer - 1], v[2 * layer - 1] = between
            best = before
    for k in range(2 * reached + 1, knots):
        u[k], v[k] = u[2 * reached], 0.0
    return u, v
