"""The pose that control steers by: noisy poses, propagated by odometry and gyroscope.

An extended Kalman filter. It also estimates what is not measured: the gyroscope's bias, the difference
between the wheel angle and the reported angle, and the compliance of the tyres. A single pose of localization
is accurate to centimetres; their mean over seconds is accurate to millimetres.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, Pose2, wrap_angle

# Entries of the mean: pose in the map, then the three that are not measured.
FX, FY, FYAW, GYRO_BIAS, STEER_BIAS, COMPLIANCE = range(6)
SIZE = 6


class PoseFilter(msgspec.Struct, frozen=True):
    """Measurement noise, and process noise of the states.

    heading_rad_per_m     heading noise over position noise, which localization gives; 0.3 degrees at 2 cm
    position_m_min, heading_rad_min  least standard deviation of a pose
    gyro_radps            noise of a yaw rate sample
    turn_radps            noise of the yaw rate from the wheel angle, model errors included
    along_mps, across_mps process noise of the position, m/s at 1 Hz
    yaw_rads, gyro_bias_rads, steer_bias_rads, compliance_s   process noise per square root of a second
    gate_m, gate_rad      a pose farther away is an outlier; after outliers_max in a row the filter restarts
    """

    heading_rad_per_m: float = 0.26
    position_m_min: float = 0.003
    heading_rad_min: float = 0.0006
    gyro_radps: float = 0.003
    turn_radps: float = 0.006
    along_mps: float = 0.01
    across_mps: float = 0.0015
    yaw_rads: float = 0.0006
    gyro_bias_rads: float = 0.00002
    steer_bias_rads: float = 0.0004
    compliance_s: float = 0.02
    steer_bias_rad_max: float = 0.05
    compliance_min: float = 0.02
    compliance_max: float = 2.0
    gate_m: float = 0.5
    gate_rad: float = 0.2
    outliers_max: int = 50

    def row(self) -> Array:
        """(16,) the parameters for the kernels, in the order of the fields up to `gate_rad`."""
        return np.array(msgspec.structs.astuple(self)[:16], dtype=np.float64)


class PoseFilterState(msgspec.Struct, frozen=True):
    """mean (6,), covariance (6, 6).

    stamp_ns, fix_ns  stamp of the state, 0 before the first pose; stamp of the last fix
    outliers          poses in a row outside the gate; no_pose_s: time since the last one inside
    """

    mean: Array
    covariance: Array
    stamp_ns: int = 0
    fix_ns: int = 0
    outliers: int = 0
    no_pose_s: float = 0.0


def initial_filter_state(steer_bias_rad: float = 0.0) -> PoseFilterState:
    """The state before the first pose, with nominal tyres and the steering's identified bias."""
    return PoseFilterState(
        np.array((0.0, 0.0, 0.0, 0.0, steer_bias_rad, 1.0)), np.diag((0.0, 0.0, 0.0, 1e-6, 4e-4, 0.09))
    )


def reset_at(
    pose_estimate: PoseFilterState, pose_map: Pose2, std_m: float, heading_std_rad: float, stamp_ns: int
) -> PoseFilterState:
    """The state started again at a pose; biases and compliance are kept."""
    mean, covariance = pose_estimate.mean.copy(), pose_estimate.covariance.copy()
    mean[:3] = pose_map.x_m, pose_map.y_m, pose_map.yaw_rad
    covariance[:3, :] = covariance[:, :3] = 0.0
    for i, std in enumerate((std_m, std_m, heading_std_rad)):
        covariance[i, i] = std * std
    return PoseFilterState(mean, covariance, stamp_ns, stamp_ns)


@njit(cache=True)
def predict(mean: Array, P: Array, speed: float, yaw_rate: float, dt: float, slip: float, n: Array) -> None:
    """Propagates mean (6,) and P (6, 6) in place over dt.

    speed, yaw_rate  of the wheels and the gyroscope; slip: of the rear axle, rad per m/s2, for nominal tyres
    """
    turn = yaw_rate - mean[GYRO_BIAS]
    drift = slip * speed * turn
    course = mean[FYAW] + 0.5 * turn * dt - mean[COMPLIANCE] * drift
    cos, sin = math.cos(course), math.sin(course)
    step = speed * dt
    F = np.eye(SIZE)
    F[FX, FYAW], F[FY, FYAW] = -step * sin, step * cos
    sensitivity = -0.5 * dt + mean[COMPLIANCE] * slip * speed
    F[FX, GYRO_BIAS], F[FY, GYRO_BIAS] = -step * sin * sensitivity, step * cos * sensitivity
    F[FX, COMPLIANCE], F[FY, COMPLIANCE] = step * sin * drift, -step * cos * drift
    F[FYAW, GYRO_BIAS] = -dt
    mean[FX] += step * cos
    mean[FY] += step * sin
    mean[FYAW] = wrap_angle(mean[FYAW] + turn * dt)
    _propagate_covariance(F, P)
    motion_share = min(1.0, speed)
    along, across = (n[5] * motion_share) ** 2 * dt, (n[6] * motion_share) ** 2 * dt
    P[FX, FX] += cos * cos * along + sin * sin * across
    P[FY, FY] += sin * sin * along + cos * cos * across
    P[FX, FY] += cos * sin * (along - across)
    P[FY, FX] = P[FX, FY]
    P[FYAW, FYAW] += (n[7] ** 2 * motion_share + n[3] ** 2 * dt) * dt
    P[GYRO_BIAS, GYRO_BIAS] += n[8] ** 2 * dt
    P[STEER_BIAS, STEER_BIAS] += n[9] ** 2 * motion_share * dt
    P[COMPLIANCE, COMPLIANCE] += n[10] ** 2 * motion_share * dt


@njit(cache=True)
def _propagate_covariance(F: Array, P: Array) -> None:
    """P = F P F' in place."""
    FP = np.zeros((SIZE, SIZE))
    for i in range(SIZE):
        for k in range(SIZE):
            if F[i, k] != 0.0:
                for j in range(SIZE):
                    FP[i, j] += F[i, k] * P[k, j]
    for i in range(SIZE):
        for j in range(i, SIZE):
            total = 0.0
            for k in range(SIZE):
                total += FP[i, k] * F[j, k]
            P[i, j] = P[j, i] = total


@njit(cache=True)
def _update_scalar(mean: Array, P: Array, H: Array, innovation: float, variance: float) -> None:
    """Updates mean and P in place by one scalar measurement; H (6,)."""
    PH = np.zeros(SIZE)
    total = variance
    for i in range(SIZE):
        for j in range(SIZE):
            PH[i] += P[i, j] * H[j]
    for i in range(SIZE):
        total += H[i] * PH[i]
    for i in range(SIZE):
        mean[i] += PH[i] / total * innovation
        for j in range(SIZE):
            P[i, j] -= PH[i] * PH[j] / total


@njit(cache=True)
def update_yaw_rate(
    mean: Array, P: Array, speed: float, yaw_rate: float, wheels: float, wheelbase: float, understeer: float,
    n: Array,
) -> None:  # fmt: skip
    """Updates steering bias and compliance in place by the reported wheel angle and the yaw rate."""
    length = wheelbase + understeer * mean[COMPLIANCE] * speed * speed
    angle = wheels + mean[STEER_BIAS]
    expected = speed * math.tan(angle) / length
    H = np.zeros(SIZE)
    H[STEER_BIAS] = speed / (length * math.cos(angle) ** 2)
    H[GYRO_BIAS] = 1.0
    H[COMPLIANCE] = -expected / length * understeer * speed * speed
    _update_scalar(mean, P, H, yaw_rate - mean[GYRO_BIAS] - expected, n[4] * n[4])
    _clamp(mean, n)


@njit(cache=True)
def update_pose(
    mean: Array, P: Array, x: float, y: float, yaw: float, std_m: float, std_rad: float, n: Array
) -> bool:
    """Updates mean and P in place by a pose; False if it is outside the gate and was ignored."""
    if math.hypot(x - mean[FX], y - mean[FY]) > n[14] + 6.0 * std_m:
        return False
    if abs(wrap_angle(yaw - mean[FYAW])) > n[15] + 6.0 * std_rad:
        return False
    for i, value in enumerate((x, y, yaw)):
        H = np.zeros(SIZE)
        H[i] = 1.0
        deviation = value - mean[i]
        if i == FYAW:
            _update_scalar(mean, P, H, wrap_angle(deviation), std_rad * std_rad)
        else:
            _update_scalar(mean, P, H, deviation, std_m * std_m)
    mean[FYAW] = wrap_angle(mean[FYAW])
    _clamp(mean, n)
    return True


@njit(cache=True)
def _clamp(mean: Array, n: Array) -> None:
    mean[STEER_BIAS] = min(max(mean[STEER_BIAS], -n[11]), n[11])
    mean[COMPLIANCE] = min(max(mean[COMPLIANCE], n[12]), n[13])
