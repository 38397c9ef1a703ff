"""How fast the vehicle may be at each place of the path (Snow Lion, eq. 1 and 2, and the terminal stop)."""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.motion.path.path_samples import PathSamples
from vehicle_agent.planning.motion.request import ClearanceLaw, DrivingLimits, Vehicle

# Why a limit holds, by number.
CAUSES: tuple[SpeedLimitReason, ...] = (
    "speed_limit",
    "curve",
    "steering",
    "stop",
    "implausible_prediction",
    "pedestrian_clearance",
    "yielding",
)
LIMIT, CURVE, STEERING, STOP, DOUBT, CLEARANCE, YIELDING = range(len(CAUSES))


class PlaceLimits(msgspec.Struct, frozen=True):
    """speed_mps (n,) by sample, reachable from above with the comfortable deceleration; cause (n,) number."""

    speed_mps: np.ndarray
    cause: np.ndarray


def place_limits(
    samples: PathSamples,
    given_mps: Array,
    stop_u_m: float,
    limits: DrivingLimits,
    vehicle: Vehicle,
    cap_mps: float,
    v0_mps: float,
) -> PlaceLimits:
    """Limits that do not depend on time; given_mps (n,) at the samples, cap_mps while something is doubted.

    A start at v0_mps that is above a given limit comes down to it comfortably: such a limit is a rule, while
    a curve or a stop is a fact.
    """
    curve = np.sqrt(limits.lateral_accel_mps2_max / np.maximum(np.abs(samples.curvature_1pm), 1e-6))
    steering = vehicle.curvature_rate_1pmps_max / np.maximum(np.abs(samples.curvature_slope_1pm2), 1e-6)
    # A vehicle at rest must be able to set off: steering at a crawl is no matter of comfort.
    steering = np.maximum(steering, 0.6)
    given = np.minimum(np.minimum(np.maximum(given_mps, 0.0), limits.speed_mps_max), cap_mps)
    lag_m = v0_mps * limits.decel_mps2_comfort / limits.jerk_mps3_max
    coming_down = v0_mps**2 - 2.0 * limits.decel_mps2_comfort * np.maximum(samples.u_m - lag_m, 0.0)
    given = np.maximum(given, np.sqrt(np.maximum(coming_down, 0.0)))
    stop = np.where(samples.u_m >= stop_u_m, 0.0, np.inf)
    each = np.stack([given, 0.99 * curve, steering, stop])
    cause = np.argmin(each, axis=0)
    lowest = each[cause, np.arange(len(given))]
    cause = np.where((cause == LIMIT) & np.isfinite(cap_mps), DOUBT, cause)
    speed, cause = backward_pass(samples.u_m, lowest, cause, stop_u_m, limits.decel_mps2_comfort)
    return PlaceLimits(speed, cause)


@njit(cache=True)
def backward_pass(
    u: Array, limit: Array, cause: IntArray, stop_u: float, decel: float
) -> tuple[Array, IntArray]:
    """v_i^2 <= v_i+1^2 + 2 decel du, and <= 2 decel (stop - u): the cause is carried with the limit."""
    n = u.shape[0]
    v, why = limit.copy(), cause.copy()
    for i in range(n - 1, -1, -1):
        stop = np.sqrt(2.0 * decel * max(stop_u - u[i], 0.0))
        if stop < v[i]:
            v[i], why[i] = stop, STOP
        if i < n - 1:
            before = np.sqrt(v[i + 1] * v[i + 1] + 2.0 * decel * (u[i + 1] - u[i]))
            if before < v[i]:
                v[i], why[i] = before, why[i + 1]
    return v, why


def clearance_speed_mps(law: ClearanceLaw, clearance_m: float) -> float:
    """Eq. 2 with the position between two thresholds normalised to 0..1 (the paper's lerp takes c itself)."""
    return float(law_speed(clearance_m, law))


@njit(cache=True)
def law_speed(c: float, law: ClearanceLaw) -> float:
    """Eq. 2."""
    speed: float = law.speed_mps_max
    if c < law.delta_m_min:
        speed = law.speed_mps_min
    elif c < law.delta_m_mdn:
        speed = _lerp(c, law.delta_m_min, law.delta_m_mdn, law.speed_mps_min, law.speed_mps_mdn)
    elif c < law.delta_m_max:
        speed = _lerp(c, law.delta_m_mdn, law.delta_m_max, law.speed_mps_mdn, law.speed_mps_max)
    return speed


@njit(cache=True)
def _lerp(x: float, x0: float, x1: float, y0: float, y1: float) -> float:
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)


@njit(cache=True)
def backward_in_time(limit: Array, u: Array, decel: float, dt: float) -> Array:
    """(K, n) limits by knot and sample, lowered so that braking with `decel` keeps every later one.

    At knot k and place u (n,), n of at least 2, a speed v is allowed when v - decel dt is, where the vehicle
    is one knot later.
    """
    out = limit.copy()
    knots, n = limit.shape
    for k in range(knots - 2, -1, -1):
        j_later = 0
        for j in range(n):
            v = out[k, j]
            for _ in range(3):
                ahead = u[j] + max(v - 0.5 * decel * dt, 0.0) * dt
                # The last sample has none after it: it is reckoned from the one before.
                j_later = min(j, n - 2)
                while j_later < n - 2 and u[j_later + 1] < ahead:
                    j_later += 1
                # A path that stands still has samples at one place: there is nothing between them.
                span = max(u[j_later + 1] - u[j_later], 1e-9)
                w = min(max((ahead - u[j_later]) / span, 0.0), 1.0)
                later = out[k + 1, j_later] + w * (out[k + 1, j_later + 1] - out[k + 1, j_later])
                v = min(out[k, j], later + decel * dt)
            out[k, j] = v
    return out
