"""The speed as piecewise polynomials of constant jerk: one quadratic program (Snow Lion, "Motion planning").

Knots k = 0..N a step dt apart; u is the way along the path. The bounds of v, a and jerk are hard; the
corridor and the limits that depend on the place are soft with exact penalties, so that the program always
has a solution: braking as hard as the bounds allow satisfies every hard row (`brake_envelope`).
Solved by PIQP (Schwan et al. 2023).
"""

import math
from functools import lru_cache
from typing import NamedTuple

import msgspec
import numpy as np
import piqp  # type: ignore[import-untyped]
from numba import njit
from scipy.sparse import csc_matrix

from contract.geometry import Array, IntArray

_INF = np.inf
_GAP, _SLOPE, _ANSWER = 1e5, 1e6, 1e7


class SpeedWeights(msgspec.Struct, frozen=True):
    """Costs and penalties of the program.

    Costs of one second of: (v - desired)^2, a^2, jerk^2. Penalties, linear and squared, of a metre beyond the
    hard corridor, beyond the soft corridor, and of 1 m/s above a limit of the place.

    gap_s  this many seconds' way stay free before the soft corridor's end, as a reserve
    now, now_s  right now a second of (v - desired)^2 costs 1 + now times as much as one far ahead; the extra
                falls with the time constant now_s
    """

    speed: float = 1.0
    accel: float = 0.15
    jerk: float = 0.15
    hard: float = 2000.0
    soft: float = 6.0
    limit: float = 100.0
    gap_s: float = 0.4
    now: float = 3.0
    now_s: float = 1.5

    def urgency(self, knots: int, dt_s: float) -> Array:
        """(knots,) from now on: what a second below the desired speed costs, relative to one far ahead.

        So the vehicle brakes late: people may yet let it pass, and whom a vehicle slows down for walks first.
        """
        times_s: Array = dt_s * np.arange(knots, dtype=np.float64)
        return 1.0 + self.now * np.exp(-times_s / self.now_s)


class SpeedBounds(msgspec.Struct, frozen=True):
    """Hard bounds; decelerations are positive. A start above the limit comes down at the comfortable one.

    accel_fade_1ps  by so much the largest acceleration falls for each 1 m/s; at rest it is accel_mps2_max
    """

    accel_mps2_max: float
    decel_mps2_comfort: float
    decel_mps2_max: float
    jerk_mps3_max: float
    accel_fade_1ps: float = 0.0


class SpeedCorridor(msgspec.Struct, frozen=True):
    """What knots 1..N should keep, all (N,): low <= u, u + gap_s v <= high, softly
    u + SpeedWeights.gap_s v <= soft, v <= limit + slope (u - at), also of v + answer_s a, and v near the
    desired speed. answer_s: so long the vehicle goes on accelerating before it answers to who limits it.
    """

    low_m: np.ndarray
    high_m: np.ndarray
    gap_s: np.ndarray
    soft_m: np.ndarray
    at_m: np.ndarray
    limit_mps: np.ndarray
    slope_1ps: np.ndarray
    answer_s: np.ndarray
    desired_mps: np.ndarray


class SpeedStart(msgspec.Struct, frozen=True):
    """How the vehicle moves at knot 0. held_jerk_mps3: of the first piece, which is commanded already and can
    no longer be changed; None for a free one."""

    speed_mps: float
    accel_mps2: float
    held_jerk_mps3: float | None = None

    def after(self, dt_s: float) -> tuple[float, float, float]:
        """u, v, a when the held piece ends; at once without one."""
        v, a, j = self.speed_mps, self.accel_mps2, self.held_jerk_mps3
        if j is None:
            return 0.0, v, a
        return v * dt_s + a * dt_s**2 / 2 + j * dt_s**3 / 6, v + a * dt_s + 0.5 * j * dt_s**2, a + j * dt_s


class SpeedPlan(msgspec.Struct, frozen=True):
    """Knots 0..N: u, v, a (N + 1,), jerk (N,) of each piece; the worst excess over the corridor; solved."""

    dt_s: float
    u_m: np.ndarray
    v_mps: np.ndarray
    a_mps2: np.ndarray
    jerk_mps3: np.ndarray
    excess_m: float
    solved: bool
    iterations: int


class _Form(NamedTuple):
    """What all programs of one size and weights share, ordered as in `solve_speed`.

    below   the inequality rows; the data at `gaps`, `answers` (n,) and `slopes` (2 n,) are each program's own
    linear  (8 n,) the costs' linear part, without the desired speed
    pull    (n,) the costs' linear part for each 1 m/s of the desired speed
    """

    cost: csc_matrix
    linear: Array
    pull: Array
    equal: csc_matrix
    below: csc_matrix
    gaps: IntArray
    slopes: IntArray
    answers: IntArray


@lru_cache(maxsize=4)
def _form(n: int, dt: float, weights: SpeedWeights, accel_fade_1ps: float) -> _Form:
    per_second = [0.0, weights.speed, weights.accel, weights.jerk]
    beyond = [weights.hard, weights.soft, weights.hard, weights.limit]
    quadratic = 2.0 * dt * np.repeat(per_second + beyond, n)
    quadratic[:n] = 1e-6
    quadratic[n : 2 * n] *= weights.urgency(n + 1, dt)[1:]
    linear = dt * np.repeat([0.0] * 4 + beyond, n)
    cost = csc_matrix((quadratic, np.arange(8 * n), np.arange(8 * n + 1)), shape=(8 * n, 8 * n))
    equal, below = _rows(n, dt, weights.gap_s, accel_fade_1ps)
    own = [np.flatnonzero(below.data == mark) for mark in (_GAP, _SLOPE, _ANSWER)]
    return _Form(cost, linear, -quadratic[n : 2 * n], equal, below, *own)


def _rows(n: int, dt: float, gap_s: float, accel_fade_1ps: float) -> tuple[csc_matrix, csc_matrix]:
    """Equality rows and inequality rows; gaps and slopes keep their places in the pattern."""
    rows: list[tuple[int, int, float]] = []
    for k in range(n):
        u, v, a, j = k, n + k, 2 * n + k, 3 * n + k
        rows += [(3 * k, u, -1.0), (3 * k + 1, v, -1.0), (3 * k + 2, a, -1.0)]
        rows += [(3 * k, j, dt**3 / 6), (3 * k + 1, j, dt**2 / 2), (3 * k + 2, j, dt)]
        if k:
            rows += [(3 * k, u - 1, 1.0), (3 * k, v - 1, dt), (3 * k, a - 1, dt**2 / 2)]
            rows += [(3 * k + 1, v - 1, 1.0), (3 * k + 1, a - 1, dt), (3 * k + 2, a - 1, 1.0)]
    i, j_, x = (np.array(column) for column in zip(*rows, strict=True))
    equal = csc_matrix((x, (i, j_)), shape=(3 * n, 8 * n))
    rows = []
    for k in range(n):
        rows += [(k, k, 1.0), (k, n + k, _GAP), (k, 4 * n + k, -1.0)]
        rows += [(n + k, k, 1.0), (n + k, n + k, gap_s), (n + k, 5 * n + k, -1.0)]
        rows += [(2 * n + k, k, 1.0), (2 * n + k, 6 * n + k, 1.0)]
        rows += [(3 * n + k, n + k, 1.0), (3 * n + k, k, _SLOPE), (3 * n + k, 7 * n + k, -1.0)]
        rows += [(4 * n + k, n + k, 1.0), (4 * n + k, k, _SLOPE), (4 * n + k, 7 * n + k, -1.0)]
        rows += [(4 * n + k, 2 * n + k, _ANSWER)]
        rows += [(5 * n + k, 2 * n + k, 1.0), (5 * n + k, n + k, accel_fade_1ps)]
    i, j_, x = (np.array(column) for column in zip(*rows, strict=True))
    below = csc_matrix((x, (i, j_)), shape=(6 * n, 8 * n))
    below.sort_indices()
    return equal, below


@njit(cache=True)
def brake_envelope(v0: float, a0: float, decel: float, jerk: float, dt: float, n: int) -> Array:
    """(n + 1, 3) u, v, a when braking at once as hard as the bounds allow, standing still afterwards.

    The jerk is constant between two knots. The brake is released so that a reaches 0 together with v.
    """
    out = np.zeros((n + 1, 3))
    out[0, 1], out[0, 2] = v0, a0
    u, v, a = 0.0, v0, a0
    for k in range(1, n + 1):
        if v > 0.0:
            after = _accel_after(v, a, decel, jerk, dt)
            reached = v + 0.5 * (a + after) * dt
            is_harder = a < -decel
            if reached <= 0.02 and (is_harder or after <= 0.0):
                u, v, a = u + 0.5 * v * dt, 0.0, 0.0
            else:
                u += v * dt + (2.0 * a + after) * dt * dt / 6.0
                v, a = reached, after
        else:
            a = 0.0
        out[k, 0], out[k, 1], out[k, 2] = u, v, a
    return out


@njit(cache=True)
def _accel_after(v: float, a: float, decel: float, jerk: float, dt: float) -> float:
    """The lowest acceleration at the next knot from which a vehicle at v > 0 can still stop smoothly."""
    if a < -decel:
        # Harder than allowed at the start: back to the bound first.
        return min(a + jerk * dt, -decel)
    after = a
    for change in (-1.0, -0.5, 0.0, 0.5, 1.0):
        after = a + change * jerk * dt
        if change < 0.0 and a > -decel:
            after = max(after, -decel)
        elif change < 0.0:
            continue
        reached = v + 0.5 * (a + after) * dt
        if reached >= after * after / (2.0 * jerk) - 1e-9 or after >= 0.0:
            break
    return min(after, max(a, 0.0))


def _least_accel_mps2(speed_mps: float, bounds: SpeedBounds) -> float:
    """Harder braking would roll the vehicle back before the jerk bound lets the brake be released."""
    return -0.95 * math.sqrt(2.0 * bounds.jerk_mps3_max * speed_mps)


def started(
    speed_mps: float, accel_mps2: float, held_jerk_mps3: float | None, bounds: SpeedBounds, dt_s: float
) -> SpeedStart:
    """A start that a plan within the bounds can continue from.

    A start that would roll back comes to rest instead, with a jerk above the bound. A held jerk that leads
    out of the bounds is dropped.
    """
    v = max(speed_mps, 0.0)
    a = max(accel_mps2, _least_accel_mps2(v, bounds))
    held = held_jerk_mps3
    if held is not None:
        _, v1, a1 = SpeedStart(v, a, held).after(dt_s)
        rolls = v1 < 0.0 or a1 < _least_accel_mps2(v1, bounds)
        beyond = abs(held) > bounds.jerk_mps3_max or not -bounds.decel_mps2_max <= a1 <= bounds.accel_mps2_max
        held = None if rolls or beyond else held
    return SpeedStart(v, a, held)


def brake_from(start: SpeedStart, decel_mps2: float, jerk_mps3: float, dt_s: float, n: int) -> Array:
    """(n + 1, 3) `brake_envelope` of a start, its held piece first."""
    u, v, a = start.after(dt_s)
    envelope: Array = brake_envelope(v, a, decel_mps2, jerk_mps3, dt_s, n)
    if start.held_jerk_mps3 is None:
        return envelope
    return np.vstack([(0.0, start.speed_mps, start.accel_mps2), envelope[:-1] + np.array([u, 0.0, 0.0])])


def solve_speed(
    start: SpeedStart,
    corridor: SpeedCorridor,
    bounds: SpeedBounds,
    speed_mps_max: float,
    weights: SpeedWeights,
    dt_s: float,
) -> SpeedPlan:
    """The smoothest speed near the desired one inside the corridor, from u = 0 at the start (see `started`).

    Hard bounds are widened where the start itself is outside. A start above the limit may come down as
    `brake_envelope` does. A start that brakes harder than allowed may release the brake at the jerk bound.
    """
    n = len(corridor.high_m)
    form = _form(n, dt_s, weights, bounds.accel_fade_1ps)
    linear = form.linear.copy()
    linear[n : 2 * n] = form.pull * corridor.desired_mps
    below = form.below.copy()
    below.data[form.gaps], below.data[form.answers] = corridor.gap_s, corridor.answer_s
    # The two rows of a knot's limit are neighbours in the column of its way.
    below.data[form.slopes] = -np.repeat(corridor.slope_1ps, 2)
    envelope = brake_from(start, bounds.decel_mps2_comfort, bounds.jerk_mps3_max, dt_s, n)
    lower, upper = _corridor_rows(corridor)
    # A start that accelerates more than allowed at its speed comes down as fast as the jerk allows.
    faded = np.maximum(bounds.accel_mps2_max, envelope[1:, 2] + bounds.accel_fade_1ps * envelope[1:, 1])
    lower, upper = np.append(lower, np.full(n, -_INF)), np.append(upper, faded + 1e-6)
    x_l, x_u = _variable_bounds(n, start, bounds, speed_mps_max, dt_s, envelope)
    solver = _solver()
    right = _start_rows(n, start, dt_s)
    solver.setup(form.cost, linear, form.equal, right, below, lower, upper, x_l, x_u)
    status = solver.solve()
    z = np.asarray(solver.result.x)
    u, v, a, j = (np.clip(z[i * n : (i + 1) * n], -1e9, 1e9) for i in range(4))
    excess = float(np.max(np.maximum(z[4 * n : 5 * n], z[6 * n : 7 * n]), initial=0.0))
    return SpeedPlan(
        dt_s,
        np.concatenate([[0.0], u]),
        np.concatenate([[start.speed_mps], v]),
        np.concatenate([[start.accel_mps2], a]),
        j,
        excess,
        status == piqp.PIQP_SOLVED and bool(np.isfinite(z).all()),
        int(solver.result.info.iter),
    )


def _variable_bounds(
    n: int, start: SpeedStart, bounds: SpeedBounds, speed_mps_max: float, dt_s: float, envelope: Array
) -> tuple[Array, Array]:
    """((8 n,), (8 n,)) of u, v, a, jerk and the four excesses."""
    t = dt_s * np.arange(1, n + 1)
    jerk = bounds.jerk_mps3_max
    coasting = np.maximum(start.accel_mps2 - jerk * t, 0.0)
    v_max = np.maximum(speed_mps_max, envelope[1:, 1] + 0.05)
    x_l = np.full(8 * n, 0.0)
    x_u = np.full(8 * n, _INF)
    x_l[:n] = -0.1
    x_l[n : 2 * n], x_u[n : 2 * n] = -1e-4, v_max
    x_l[2 * n : 3 * n] = np.minimum(-bounds.decel_mps2_max, start.accel_mps2 + jerk * t)
    x_u[2 * n : 3 * n] = np.maximum(bounds.accel_mps2_max, np.maximum(coasting, 0.0))
    x_l[2 * n : 3 * n] -= 1e-6
    x_l[3 * n : 4 * n], x_u[3 * n : 4 * n] = -jerk, jerk
    if start.held_jerk_mps3 is not None:
        x_l[3 * n], x_u[3 * n] = start.held_jerk_mps3 - 1e-6, start.held_jerk_mps3 + 1e-6
    return x_l, x_u


def _start_rows(n: int, start: SpeedStart, dt_s: float) -> Array:
    """(3 n,) right-hand sides of the equality rows."""
    v0_mps, a0_mps2 = start.speed_mps, start.accel_mps2
    right = np.zeros(3 * n)
    right[0] = -(v0_mps * dt_s + 0.5 * a0_mps2 * dt_s**2)
    right[1] = -(v0_mps + a0_mps2 * dt_s)
    right[2] = -a0_mps2
    return right


def _corridor_rows(corridor: SpeedCorridor) -> tuple[Array, Array]:
    """((5 n,), (5 n,)) bounds of the inequality rows, but for the last n."""
    n = len(corridor.high_m)
    limit = corridor.limit_mps - corridor.slope_1ps * corridor.at_m
    upper = np.concatenate([corridor.high_m, corridor.soft_m, np.full(n, _INF), limit, limit])
    lower = np.full(5 * n, -_INF)
    lower[2 * n : 3 * n] = corridor.low_m
    return lower, upper


def _solver() -> piqp.SparseSolver:
    solver = piqp.SparseSolver()
    solver.settings.max_iter = 60
    solver.settings.eps_abs = 1e-5
    solver.settings.eps_rel = 1e-6
    # Where the corridor cannot be kept its penalties cost 1e5 and more; the duality gap is judged relative to
    # that.
    solver.settings.eps_duality_gap_abs = 1e-6
    solver.settings.eps_duality_gap_rel = 1e-6
    return solver
