"""Who goes first: a breadth-first search on the s-t graph (Snow Lion, "Motion planning").

Layers are time slots; a node is (u, v, a), and in each cell of u and v only the cheapest one is kept. What it
finds is a corridor for the speed program: whom the vehicle yields to and whom it goes before.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, IntArray
from vehicle_agent.planning.motion.occupancy import Occupancy
from vehicle_agent.planning.motion.request import PASS_YIELD, DrivingLimits

_CELL_M, _CELL_MPS = 0.4, 0.25
_STILL_MPS = 0.05


class Graph(msgspec.Struct, frozen=True):
    """The s-t graph at knots of dt_s: who is where, merged over the slots around each knot.

    low_m, high_m, soft_low_m, soft_high_m (K, a); of relevant agents only, `who` (a,) their rows
    """

    dt_s: float
    low_m: np.ndarray
    high_m: np.ndarray
    soft_low_m: np.ndarray
    soft_high_m: np.ndarray
    who: np.ndarray


class Searched(msgspec.Struct, frozen=True):
    """u_m, v_mps (K,) at the knots; nodes used; whether a way to the end was found."""

    u_m: np.ndarray
    v_mps: np.ndarray
    nodes: int
    found: bool


class Corridor(msgspec.Struct, frozen=True):
    """What the speed program shall keep, (K,) by knot; yields_to, passes rows of Agents.

    end_speed_mps  of the one ahead at the last knot, along the path
    """

    low_m: np.ndarray
    high_m: np.ndarray
    soft_m: np.ndarray
    yields_to: np.ndarray
    passes: np.ndarray
    end_speed_mps: float


def graph(occupancy: Occupancy, pass_rule: IntArray, slots_per_knot: int, dt_s: float, gap_m: float) -> Graph:
    """Occupancy at the knots: each takes what is taken half a knot before and after it, too.

    Who must be yielded to blocks its stretch, and all beyond it, from now until it has left.
    """
    low, high, soft_low, soft_high = merged(
        occupancy.hard_low_m,
        occupancy.hard_high_m,
        occupancy.soft_low_m,
        occupancy.soft_high_m,
        slots_per_knot,
    )
    who = np.flatnonzero(((low <= high) | (soft_low <= soft_high)).any(axis=0))
    low, high, soft_low, soft_high = (part[:, who].copy() for part in (low, high, soft_low, soft_high))
    taken = low <= high
    for column in np.flatnonzero((pass_rule[who] == PASS_YIELD) & taken.any(axis=0)):
        times = np.flatnonzero(taken[:, column])
        if low[times[0], column] <= 0.0:
            continue
        until = slice(0, times[-1] + 1)
        low[: times[0], column] = low[times[0], column]
        high[until, column] = np.inf
    taken = low <= high
    soft_low = np.where(taken, np.minimum(low - gap_m, soft_low), soft_low)
    soft_high = np.where(taken, np.maximum(high + 0.5 * gap_m, soft_high), soft_high)
    return Graph(dt_s, low, high, soft_low, soft_high, who)


@njit(cache=True)
def merged(
    low: Array, high: Array, soft_low: Array, soft_high: Array, per_knot: int
) -> tuple[Array, Array, Array, Array]:
    """Slots (T, a) to knots (K, a): least low and greatest high within half a knot."""
    knots = (low.shape[0] - 1) // per_knot + 1
    half = (per_knot + 1) // 2
    agents = low.shape[1]
    out = np.empty((4, knots, agents))
    for k in range(knots):
        first, last = max(0, k * per_knot - half), min(low.shape[0], k * per_knot + half + 1)
        for a in range(agents):
            out[0, k, a] = np.min(low[first:last, a])
            out[1, k, a] = np.max(high[first:last, a])
            out[2, k, a] = np.min(soft_low[first:last, a])
            out[3, k, a] = np.max(soft_high[first:last, a])
    return out[0], out[1], out[2], out[3]


def search(
    graph: Graph,
    place_u_m: Array,
    place_limit_mps: Array,
    clearance_limit_mps: Array,
    v0_mps: float,
    a0_mps2: float,
    limits: DrivingLimits,
    nodes_max: int,
) -> Searched:
    """The best way through the graph from u = 0 with v0, a0.

    place_u_m, place_limit_mps (n,); clearance_limit_mps (K, n). Standing is allowed anywhere: who walks into a
    vehicle that stands has not been hit by it.
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
    return Searched(u, v, nodes, found)


@njit(cache=True)
def raster(low: Array, high: Array, soft_low: Array, soft_high: Array, cells: int, spacing: float) -> Array:
    """(K, cells) cost per second of being there: inf in a taken cell, 2 in a soft one."""
    knots, agents = low.shape
    out = np.zeros((knots, cells))
    for k in range(knots):
        for a in range(agents):
            if soft_low[k, a] <= soft_high[k, a]:
                first = max(0, int(math.ceil(soft_low[k, a] / spacing)))
                last = min(cells - 1.0, math.floor(soft_high[k, a] / spacing))
                for c in range(first, int(last) + 1):
                    out[k, c] = max(out[k, c], 2.0)
            if low[k, a] <= high[k, a]:
                first = max(0, int(math.ceil(low[k, a] / spacing)))
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
                    cell = int(math.ceil(u / spacing))
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


def corridor(graph: Graph, way: Searched) -> Corridor:
    """Which side of everybody the way keeps, and the room that leaves.

    A soft stretch that the way itself enters is given up: the search has found that waiting costs more.
    """
    low, high, soft, side = sides(graph.low_m, graph.high_m, graph.soft_low_m, graph.soft_high_m, way.u_m)
    knots = len(high)
    step = high[-1] - high[max(knots - 6, 0)]
    end_speed = max(step / (5.0 * graph.dt_s), 0.0) if np.isfinite(step) else 0.0
    return Corridor(low, high, soft, graph.who[side == 1], graph.who[side == 2], min(end_speed, 5.0))


@njit(cache=True)
def sides(
    low: Array, high: Array, soft_low: Array, soft_high: Array, u: Array
) -> tuple[Array, Array, Array, IntArray]:
    """((K,) low, (K,) high, (K,) soft high, (a,) 1 yielded to, 2 passed before, 0 neither)."""
    knots, agents = low.shape
    out_low, out_high, out_soft = np.full(knots, -1e3), np.full(knots, 1e3), np.full(knots, 1e3)
    side = np.zeros(agents, np.int64)
    for a in range(agents):
        enters: BoolArray = (soft_low[:, a] < u) & (u < soft_high[:, a])
        gives_up = np.any(enters & ~((low[:, a] <= u) & (u <= high[:, a])))
        for k in range(1, knots):
            if low[k, a] <= high[k, a]:
                if u[k] <= low[k, a] or (u[k] < high[k, a] and u[k] - low[k, a] <= high[k, a] - u[k]):
                    out_high[k] = min(out_high[k], max(low[k, a], 0.0))
                    side[a] = 1
                elif u[k] >= high[k, a]:
                    out_low[k] = max(out_low[k], high[k, a])
                    if side[a] == 0:
                        side[a] = 2
                else:
                    out_high[k] = min(out_high[k], u[k])
                    side[a] = 1
            if soft_low[k, a] <= soft_high[k, a] and not gives_up and u[k] <= soft_low[k, a]:
                out_soft[k] = min(out_soft[k], soft_low[k, a])
    return out_low, out_high, out_soft, side
