"""The pose by wheel speed and gyroscope, corrected by positions and headings: an extended Kalman filter.

Receivers average their noise well and wander slowly: a fix has nearly the same error as the one before. So
the receiver's error is a state of its own (first-order Gauss-Markov), and a hundred fixes in a row are little
more than one. Without it the filter would believe millimetres while it is centimetres off.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, wrap_angle

# Entries of the mean: pose in the map, the gyroscope's bias (rad/s), the wheels' scale error (the speed is
# 1 + scale times the reported one), the rear axle's slip angle per lateral acceleration (rad per m/s2), and
# the receiver's error of place (m) and heading (rad).
X, Y, YAW, GYRO_BIAS, SCALE, SLIP, OFFSET_X, OFFSET_Y, OFFSET_YAW = range(9)
SIZE = 9


class OdometryNoise(msgspec.Struct, frozen=True):
    """Process noise, as growth of a standard deviation per square root of a second, and first deviations.

    along_mps, across_ratio  of the position while the wheels turn; across: share of the speed, for side slip
    yaw_radps, turn_ratio    of the heading while the vehicle moves; of the turning rate
    gyro_bias_radps, scale, slip_s2pm  of the gyroscope's bias, the wheels' scale and the slip
    gyro_bias_radps_first, scale_first, slip_s2pm_first  standard deviations before anything was learned
    offset_s, offset_share   time constant of the receiver's error, and its share in the stated variance;
                             the rest is white
    """

    along_mps: float = 0.012
    across_ratio: float = 0.004
    yaw_radps: float = 0.0008
    turn_ratio: float = 0.015
    gyro_bias_radps: float = 2e-5
    scale: float = 2e-4
    slip_s2pm: float = 1e-4
    gyro_bias_radps_first: float = 0.01
    scale_first: float = 0.02
    slip_s2pm_first: float = 0.008
    offset_s: float = 30.0
    offset_share: float = 0.8

    def row(self) -> Array:
        """(12,) in the order of the fields, for the kernels."""
        return np.array(msgspec.structs.astuple(self), dtype=np.float64)


@njit(cache=True)
def propagate_pose(
    mean: Array,
    P: Array,
    wheel_mps: float,
    yaw_rate: float,
    dt: float,
    jolt_m: float,
    place_std: float,
    heading_std: float,
    n: Array,
) -> None:
    """Propagates mean (9,) and P (9, 9) in place over dt seconds, by the midpoint rule.

    wheel_mps    as reported; 0.0: the vehicle stands, and neither place nor heading changes
    yaw_rate     of the gyroscope, rad/s, its bias included
    jolt_m       standard deviation along the way of what was driven between two reports of the wheels
    place_std, heading_std  of the receiver, m and rad; n: row of `OdometryNoise`
    """
    _propagate_offset(mean, P, dt, place_std, heading_std, n)
    P[GYRO_BIAS, GYRO_BIAS] += n[4] * n[4] * dt
    if wheel_mps == 0.0:
        return
    speed, turn = (1.0 + mean[SCALE]) * wheel_mps, yaw_rate - mean[GYRO_BIAS]
    course = mean[YAW] + 0.5 * turn * dt - mean[SLIP] * speed * turn
    cos, sin, step = math.cos(course), math.sin(course), speed * dt
    F = np.eye(SIZE)
    F[X, YAW], F[Y, YAW] = -step * sin, step * cos
    by_bias = -0.5 * dt + mean[SLIP] * speed
    F[X, GYRO_BIAS], F[Y, GYRO_BIAS] = -step * sin * by_bias, step * cos * by_bias
    F[X, SLIP], F[Y, SLIP] = step * sin * speed * turn, -step * cos * speed * turn
    F[X, SCALE], F[Y, SCALE] = wheel_mps * dt * cos, wheel_mps * dt * sin
    F[YAW, GYRO_BIAS] = -dt
    mean[X] += step * cos
    mean[Y] += step * sin
    mean[YAW] = wrap_angle(mean[YAW] + turn * dt)
    P[:] = F @ P @ F.T
    along, across = n[0] * n[0] * dt + jolt_m * jolt_m, (n[1] * speed) ** 2 * dt
    P[X, X] += cos * cos * along + sin * sin * across
    P[Y, Y] += sin * sin * along + cos * cos * across
    P[X, Y] += cos * sin * (along - across)
    P[Y, X] = P[X, Y]
    P[YAW, YAW] += (n[2] * n[2] + (n[3] * turn) ** 2) * dt
    P[SCALE, SCALE] += n[5] * n[5] * dt
    P[SLIP, SLIP] += (n[6] * min(1.0, abs(speed * turn))) ** 2 * dt


@njit(cache=True)
def _propagate_offset(
    mean: Array, P: Array, dt: float, place_std: float, heading_std: float, n: Array
) -> None:
    """The receiver's error is forgotten with its time constant and stays as large as it is stated."""
    keep = math.exp(-dt / n[10])
    for i in (OFFSET_X, OFFSET_Y, OFFSET_YAW):
        std = heading_std if i == OFFSET_YAW else place_std
        mean[i] *= keep
        P[i, :] *= keep
        P[:, i] *= keep
        P[i, i] += (1.0 - keep * keep) * n[11] * std * std


@njit(cache=True)
def restart_offset(mean: Array, P: Array, place_std: float, heading_std: float, n: Array) -> None:
    """In place: nothing is known of the receiver's error, as after a change of its kind of solution."""
    for i in (OFFSET_X, OFFSET_Y, OFFSET_YAW):
        std = heading_std if i == OFFSET_YAW else place_std
        mean[i] = 0.0
        P[i, :] = 0.0
        P[:, i] = 0.0
        P[i, i] = n[11] * std * std


@njit(cache=True)
def correct_position(mean: Array, P: Array, dx: float, dy: float, var: float, gate: float) -> float:
    """Corrects in place by a position whose deviation from mean (without the offset) is (dx, dy) m.

    var  m2 of its white noise. Returns the squared Mahalanobis distance (chi2, 2); beyond `gate` nothing
    changes.
    """
    H = np.zeros((2, SIZE))
    H[0, X] = H[0, OFFSET_X] = H[1, Y] = H[1, OFFSET_Y] = 1.0
    PH = P @ H.T
    S = H @ PH
    S[0, 0] += var
    S[1, 1] += var
    inverse = np.linalg.inv(S)
    innovation = np.array((dx - mean[OFFSET_X], dy - mean[OFFSET_Y]))
    distance = float(innovation @ inverse @ innovation)
    if distance <= gate:
        K = PH @ inverse
        mean += K @ innovation
        mean[YAW] = wrap_angle(mean[YAW])
        _subtract(P, K @ PH.T)
    return distance


@njit(cache=True)
def correct_heading(mean: Array, P: Array, turn: float, var: float, gate: float) -> float:
    """Corrects in place by a heading `turn` rad beside the mean's (without the offset); var: its white noise.

    Returns the squared Mahalanobis distance (chi2, 1); beyond `gate` nothing changes.
    """
    PH = P[:, YAW] + P[:, OFFSET_YAW]
    S = PH[YAW] + PH[OFFSET_YAW] + var
    innovation = wrap_angle(turn - mean[OFFSET_YAW])
    distance = innovation * innovation / S
    if distance <= gate:
        mean += PH * (innovation / S)
        mean[YAW] = wrap_angle(mean[YAW])
        _subtract(P, np.outer(PH, PH) / S)
    return float(distance)


@njit(cache=True)
def correct_pose(mean: Array, P: Array, innovation: Array, R: Array, gate: float) -> float:
    """Corrects in place by a measured pose; innovation (3,): x, y, yaw measured minus estimated; R (3, 3).

    Returns the squared Mahalanobis distance (chi2, 3); beyond `gate` nothing changes.
    """
    PH = P[:, :3].copy()
    S = P[:3, :3] + R
    inverse = np.linalg.inv(S)
    distance = float(innovation @ inverse @ innovation)
    if distance <= gate:
        K = PH @ inverse
        mean += K @ innovation
        mean[YAW] = wrap_angle(mean[YAW])
        _subtract(P, K @ PH.T)
    return distance


@njit(cache=True)
def correct_entry(mean: Array, P: Array, entry: int, innovation: float, var: float, gate: float) -> float:
    """Corrects in place by a measurement of one entry of the mean; innovation: measured minus estimated.

    Returns the squared Mahalanobis distance (chi2, 1); beyond `gate` nothing changes.
    """
    S = P[entry, entry] + var
    distance = innovation * innovation / S
    if distance <= gate:
        PH = P[:, entry].copy()
        mean += PH * (innovation / S)
        mean[YAW] = wrap_angle(mean[YAW])
        _subtract(P, np.outer(PH, PH) / S)
    return float(distance)


@njit(cache=True)
def _subtract(P: Array, taken: Array) -> None:
    """P - taken in place, kept symmetric."""
    for i in range(SIZE):
        for j in range(i, SIZE):
            P[i, j] -= 0.5 * (taken[i, j] + taken[j, i])
            P[j, i] = P[i, j]


def position_std_m(P: Array) -> float:
    """Standard deviation along the worst direction in the plane, from P (9, 9)."""
    a, b, c = float(P[X, X]), float(P[Y, Y]), float(P[X, Y])
    return math.sqrt(0.5 * (a + b) + math.hypot(0.5 * (a - b), c))
