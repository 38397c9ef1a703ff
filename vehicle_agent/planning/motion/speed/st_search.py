"""Who goes first: a breadth-first search on the s-t graph (Snow Lion, "Motion planning").

Layers are time slots; a node is (u, v, a), and in each cell of u and v only the cheapest one is kept. What it
finds is a corridor for the speed program: whom the vehicle yields to and whom it goes before.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.planning.motion.request import DrivingLimits
from vehicle_agent.planning.motion.speed.st_graph import StGraph

_CELL_M, _CELL_MPS = 0.4, 0.25
_STILL_MPS = 0.05


class StSearchResult(msgspec.Struct, frozen=True):
    """u_m, v_mps (K,) at the knots; nodes used; whether a way to the end was found."""

    u_m: np.ndarray
    v_mps: np.ndarray
    nodes: int
    found: bool


def search(
    graph: StGraph,
    place_u_m: Array,
    place_limit_mps: Array,
    clearance_limit_mps: Array,
    v0_mps: float,
    a0_mps2: float,
    limits: DrivingLimits,
    nodes_max: int,
) -> StSearchResult:
    """The best way through the graph from u = 0 with v0, a0.

    place_u_m, place_limit_mps (n,); clearance_limit_mps (K, n). Standing is allowed anywhere:
    who walks into a vehicle that stands has not been hit by it.
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
    u, v, nodes, found = search_kernel(
        penalty,
        np.ascontiguousarray(limit),
        spacing,
        graph.dt_s,
        v0_mps,
        a0_mps2,
        accels,
        limits.jerk_mps3_max,
        limits.decel_mps2_comfort,
        limits.decel_mps2_max,
        nodes_max,
    )
    return StSearchResult(u, v, nodes, found)


@njit(cache=True)
def raster(low: Array, high: Array, soft_low: Array, soft_high: Array, cells: int, spacing: float) -> Array:
    """(K, cells) cost per second of being there: inf in a taken cell, 2 in a soft one."""
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
    penalty: Array,
    limit: Array,
    spacing: float,
    dt: float,
    v0: float,
    a0: float,
    accels: Array,
    jerk: float,
    decel: float,
    decel_max: float,
    nodes_max: int,
) -> tuple[Array, Array, int, bool]:
    """((K,) u, (K,) v, nodes, found); a layer every second knot, costs counted at every knot."""
    knots, cells = penalty.shape
    layers = (knots - 1) // 2
    top = np.max(limit[0]) + 1.0
    speeds = int(max(v0, top) / _CELL_MPS) + 3
    node_u, node_v, node_a = np.empty(nodes_max), np.empty(nodes_max), np.empty(nodes_max)
    node_cost, parent = np.empty(nodes_max), np.full(nodes_max, -1, np.int64)
    begin = np.zeros(layers + 2, np.int64)
    node_u[0], node_v[0], node_a[0], node_cost[0] = 0.0, v0, a0, 0.0
    count = 1
    begin[1] = 1
    at = np.full((cells, speeds), -1, np.int64)
    reached = 0
    for layer in range(layers):
        at[:] = -1
        for i in range(begin[layer], begin[layer + 1]):
            for c in range(accels.shape[0]):
                a = accels[c]
                if abs(a - node_a[i]) > 2.6 * jerk * dt and not (a == accels[0] and a > node_a[i]):
                    continue
                u, v, cost = node_u[i], node_v[i], node_cost[i]
                cost += 0.03 * (a - node_a[i]) ** 2
                if v <= 0.0 and a < 0.0:
                    continue
                blocked = False
                for sub in range(2):
                    before = v
                    v = max(v + a * dt, 0.0)
                    if v > 0.0 or a >= 0.0:
                        u += 0.5 * (before + v) * dt
                    else:
                        u += 0.5 * before * before / -a
                    k = 2 * layer + 1 + sub
                    cell = int(u / spacing)
                    if cell >= cells - 1:
                        blocked = u > (cells - 1) * spacing
                        cell = cells - 2 if cells > 1 else 0
                    share = min(max(u / spacing - cell, 0.0), 1.0)
                    here = max(
                        penalty[k, cell] if share < 1.0 else 0.0, penalty[k, cell + 1] if share > 0.0 else 0.0
                    )
                    allowed = limit[k, cell] + share * (limit[k, cell + 1] - limit[k, cell])
                    if here == np.inf:
                        if v > _STILL_MPS:
                            blocked = True
                        here = 2.0
                    if blocked:
                        break
                    over = max(v - allowed, 0.0)
                    wish = max(limit[k, cell], 0.5)
                    cost += dt * (here + (wish - v) ** 2 + 20.0 * over * over + 4.0 * over)
                    if a < 0.0:
                        cost += dt * (0.4 * a * a + 2.0 * max(-a - decel, 0.0))
                    else:
                        cost += dt * 0.4 * a * a
                if blocked:
                    continue
                if layer == layers - 1:
                    # Whoever is in the way at the end of the horizon must still be stopped for.
                    gap = 0.0
                    cell = math.ceil(u / spacing)
                    while cell < cells and penalty[knots - 1, cell] != np.inf:
                        cell += 1
                    gap = max(cell * spacing - u, 0.0)
                    if v * v > 2.0 * decel_max * gap:
                        continue
                    cost += max(v * v / (2.0 * max(gap, 0.1)) - decel, 0.0) * 4.0
                iu, iv = int(u / spacing), int(v / _CELL_MPS + 0.5)
                if iu >= cells or iv >= speeds:
                    continue
                other = at[iu, iv]
                if other >= 0:
                    if cost >= node_cost[other]:
                        continue
                elif count < nodes_max:
                    other = count
                    count += 1
                    at[iu, iv] = other
                else:
                    continue
                node_u[other], node_v[other], node_a[other] = u, v, a
                node_cost[other], parent[other] = cost, i
        begin[layer + 2] = count
        if begin[layer + 2] == begin[layer + 1]:
            break
        reached = layer + 1
    best = begin[reached]
    for i in range(begin[reached], begin[reached + 1]):
        if node_cost[i] < node_cost[best]:
            best = i
    out_u, out_v = np.empty(knots), np.empty(knots)
    for layer in range(reached, -1, -1):
        out_u[2 * layer], out_v[2 * layer] = node_u[best], node_v[best]
        if layer:
            before = parent[best]
            # The knot between two layers, by the same constant acceleration.
            v = max(node_v[before] + node_a[best] * dt, 0.0)
            if v > 0.0 or node_a[best] >= 0.0:
                out_u[2 * layer - 1] = node_u[before] + 0.5 * (node_v[before] + v) * dt
            else:
                out_u[2 * layer - 1] = node_u[before] + 0.5 * node_v[before] ** 2 / -node_a[best]
            out_v[2 * layer - 1] = v
            best = before
    for k in range(2 * reached + 1, knots):
        out_u[k], out_v[k] = out_u[2 * reached], 0.0
    return out_u, out_v, count, reached == layers
