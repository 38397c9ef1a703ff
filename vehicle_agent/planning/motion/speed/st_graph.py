"""The s-t graph: which agent is on the path where and when, and the corridor of a way through it."""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, IntArray
from vehicle_agent.planning.motion.request import PASS_YIELD
from vehicle_agent.planning.motion.speed.occupancy import Occupancy

# Farther than any path leads, and finite: it is turned into a cell's number.
_BEYOND_M = 1e4


class StGraph(msgspec.Struct, frozen=True):
    """The s-t graph at knots of dt_s: occupied stretches, merged over the slots around each knot.

    low_m, high_m, soft_low_m, soft_high_m (K, a); of relevant agents only, `who` (a,) their rows
    """

    dt_s: float
    low_m: np.ndarray
    high_m: np.ndarray
    soft_low_m: np.ndarray
    soft_high_m: np.ndarray
    who: np.ndarray


class StCorridor(msgspec.Struct, frozen=True):
    """The speed program's corridor, (K,) by knot; yields_to, passes: rows of Agents.

    stands         (K,) the vehicle stands at this knot while an agent walks by or into it
    end_speed_mps  of the agent ahead at the last knot, along the path
    """

    low_m: np.ndarray
    high_m: np.ndarray
    soft_m: np.ndarray
    stands: np.ndarray
    yields_to: np.ndarray
    passes: np.ndarray
    end_speed_mps: float


def graph(
    occupancy: Occupancy, pass_rule: IntArray, slots_per_knot: int, early: IntArray, dt_s: float, gap_m: float
) -> StGraph:
    """Occupancy at the knots.

    Each knot takes what is occupied half a knot before it, and half a knot and `early` (a,) slots after it:
    an agent faster than predicted comes earlier. An agent with PASS_YIELD blocks its stretch, and all beyond
    it, from now until it has left.
    """
    low, high, soft_low, soft_high = merged(
        occupancy.hard_low_m,
        occupancy.hard_high_m,
        occupancy.soft_low_m,
        occupancy.soft_high_m,
        slots_per_knot,
        early,
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
        high[until, column] = _BEYOND_M
    taken = low <= high
    soft_low = np.where(taken, np.minimum(low - gap_m, soft_low), soft_low)
    soft_high = np.where(taken, np.maximum(high + 0.5 * gap_m, soft_high), soft_high)
    return StGraph(dt_s, low, high, soft_low, soft_high, who)


@njit(cache=True)
def merged(
    low: Array, high: Array, soft_low: Array, soft_high: Array, per_knot: int, early: IntArray
) -> tuple[Array, Array, Array, Array]:
    """Slots (T, a) to knots (K, a): least low, greatest high within half a knot, and `early` (a,) later."""
    knots = (low.shape[0] - 1) // per_knot + 1
    half = (per_knot + 1) // 2
    agents = low.shape[1]
    out = np.empty((4, knots, agents))
    for k in range(knots):
        first = max(0, k * per_knot - half)
        for a in range(agents):
            last = min(low.shape[0], k * per_knot + half + early[a] + 1)
            out[0, k, a] = np.min(low[first:last, a])
            out[1, k, a] = np.max(high[first:last, a])
            out[2, k, a] = np.min(soft_low[first:last, a])
            out[3, k, a] = np.max(soft_high[first:last, a])
    return out[0], out[1], out[2], out[3]


def corridor(graph: StGraph, way_u_m: Array) -> StCorridor:
    """The side of every agent that the way u (K,) keeps, and the corridor that remains.

    A soft stretch that the way itself enters is dropped: the search has found that waiting costs more.
    """
    low, high, soft, stands, side = sides(
        graph.low_m, graph.high_m, graph.soft_low_m, graph.soft_high_m, way_u_m
    )
    knots = len(high)
    step = high[-1] - high[max(knots - 6, 0)]
    end_speed = max(step / (5.0 * graph.dt_s), 0.0) if np.isfinite(step) else 0.0
    return StCorridor(
        low, high, soft, stands, graph.who[side == 1], graph.who[side == 2], min(end_speed, 5.0)
    )


@njit(cache=True)
def sides(
    low: Array, high: Array, soft_low: Array, soft_high: Array, u: Array
) -> tuple[Array, Array, Array, BoolArray, IntArray]:
    """((K,) low, (K,) high, (K,) soft high, (K,) stands, (a,) 1 yielded to, 2 passed before, 0 neither)."""
    knots, agents = low.shape
    out_low, out_high, out_soft = np.full(knots, -1e3), np.full(knots, 1e3), np.full(knots, 1e3)
    side = np.zeros(agents, np.int64)
    stands = np.zeros(knots, np.bool_)
    for a in range(agents):
        enters: BoolArray = (soft_low[:, a] < u) & (u < soft_high[:, a])
        gives_up = np.any(enters & ~((low[:, a] <= u) & (u <= high[:, a])))
        for k in range(1, knots):
            if low[k, a] <= high[k, a]:
                if u[k] <= low[k, a]:
                    out_high[k] = min(out_high[k], max(low[k, a], 0.0))
                    side[a] = 1
                elif u[k] >= high[k, a]:
                    out_low[k] = max(out_low[k], high[k, a])
                    if side[a] == 0:
                        side[a] = 2
                else:
                    out_high[k] = min(out_high[k], u[k])
                    stands[k] = True
                    side[a] = 1
            if soft_low[k, a] <= soft_high[k, a] and not gives_up and u[k] <= soft_low[k, a]:
                out_soft[k] = min(out_soft[k], soft_low[k, a])
    return out_low, out_high, out_soft, stands, side
