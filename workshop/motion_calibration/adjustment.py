"""The pose, the clock offset and the biases of robust least squares, and how surely each is known."""

from dataclasses import dataclass, field

import numpy as np

from contract.geometry import Array
from workshop.motion_calibration.comparison import (
    FORCE_BIAS,
    LEVER,
    OFFSET,
    RATE_BIAS,
    TURN,
    UNKNOWNS,
    Unknowns,
    integrals,
    residuals,
)
from workshop.motion_calibration.drive import InertialDrive, LidarMotion
from workshop.motion_calibration.windows import Windows

GRAVITY_MPS2 = 9.81
_MAD = 1.4826
# Where Cauchy's weight is half; 95 % efficient on normal errors.
_CAUCHY = 2.3849
_STEPS = 12
# A step that changes the weighted sum of squares by less ends it.
_CHANGE_MIN = 1e-2
# Of the numeric derivatives: rad, m, s, rad/s, m/s2, m/s2.
_SMALL = np.repeat([1e-4, 1e-3, 1e-4, 1e-5, 1e-3, 1e-3], [3, 3, 1, 3, 3, 3])
# So many windows, one after the other, say as much as one: the odometry's errors last for half a second.
_TOGETHER = 5.0
# Those by which the unit's samples have to be integrated again.
_INTEGRATED = range(6, 13)
_DEVIATION_MIN = 1e-5


@dataclass(frozen=True, slots=True)
class UnitPrior:
    """What is known of inertial units: standard deviations of their biases, and of gravity.

    axes_rad  of the unit's axes against its case: no drive tells them from the rotation that is looked for
    clock_s   what the lidar's odometry errs in time
    """

    rate_bias_radps: float = 0.02
    force_bias_mps2: float = 0.1
    gravity_mps2: float = 0.02
    axes_rad: float = 0.0015
    clock_s: float = 0.0005


@dataclass(frozen=True, slots=True, eq=False)
class LeverPrior:
    """The given lever arm, value_m (3,): right to wide_m, and to kept_m along the directions (k, 3)."""

    value_m: Array
    directions: Array = field(default_factory=lambda: np.zeros((0, 3)))
    wide_m: float = 3.0
    kept_m: float = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Adjustment:
    """What came out.

    covariance       (16, 16) of the unknowns' steps, see `comparison`
    turns_rad        (n, 3) and accelerations_mps2 (m, 3): what is left of the windows
    turn_std_rad, acceleration_std_mps2  median absolute deviations of these
    """

    unknowns: Unknowns
    covariance: Array
    turns_rad: Array
    accelerations_mps2: Array
    turn_std_rad: float
    acceleration_std_mps2: float


def adjust(
    lidar: LidarMotion, unit: InertialDrive, start: Unknowns, windows: Windows, block_s: float,
    prior: UnitPrior, lever: LeverPrior,
) -> Adjustment:  # fmt: skip
    """From a start that is nearly right, by Gauss and Newton with Cauchy's weights.

    block_s: windows that begin within so long err together; the covariance counts them as one (White 1980,
    by blocks). numpy's LinAlgError if the windows do not determine the unknowns.
    """
    unknowns = start
    for _ in range(_STEPS):
        slopes, values, _ = _linear(lidar, unit, unknowns, windows)
        known, pull = _of_priors(unknowns, prior, lever)
        information = np.einsum("nij,nik->jk", slopes, slopes) + known
        step = -np.linalg.solve(information, np.einsum("nij,ni->j", slopes, values) + pull)
        unknowns = unknowns.moved(step)
        if float(step @ information @ step) < _CHANGE_MIN:
            break
    slopes, values, stds = _linear(lidar, unit, unknowns, windows)
    known, _ = _of_priors(unknowns, prior, lever)
    covariance = _covariance(slopes, values, known, _blocks(lidar, windows, block_s))
    covariance[TURN, TURN] += prior.axes_rad**2 * np.eye(3)
    covariance[OFFSET, OFFSET] += prior.clock_s**2
    turns, accelerations = residuals(lidar, integrals(lidar, unit, unknowns), unknowns, windows)
    return Adjustment(unknowns, covariance, turns, accelerations, *stds)


def _linear(
    lidar: LidarMotion, unit: InertialDrive, unknowns: Unknowns, windows: Windows
) -> tuple[Array, Array, tuple[float, float]]:
    """(slopes (w, 3, 16), values (w, 3), standard deviations) of all windows, weighted."""
    found = integrals(lidar, unit, unknowns)
    turns, accelerations = residuals(lidar, found, unknowns, windows)
    stds = (_deviation(turns), _deviation(accelerations))
    weights = np.concatenate([_weights(turns, stds[0]), _weights(accelerations, stds[1])])
    values = np.concatenate((turns, accelerations)) * weights[:, None]
    slopes = np.empty((len(values), 3, UNKNOWNS))
    for number in range(UNKNOWNS):
        step = np.zeros(UNKNOWNS)
        step[number] = _SMALL[number]
        sides = []
        for sign in (1.0, -1.0):
            near = unknowns.moved(sign * step)
            there = integrals(lidar, unit, near) if number in _INTEGRATED else found
            sides.append(np.concatenate(residuals(lidar, there, near, windows)))
        slopes[:, :, number] = (sides[0] - sides[1]) / (2.0 * _SMALL[number]) * weights[:, None]
    return slopes, values, stds


def _deviation(values: Array) -> float:
    return max(_MAD * float(np.median(np.abs(values))), _DEVIATION_MIN)


def _weights(values: Array, std: float) -> Array:
    """(n,) square roots of Cauchy's weights over the deviation."""
    scaled = np.linalg.norm(values, axis=1) / (np.sqrt(3.0) * _CAUCHY * std)
    weights: Array = 1.0 / (np.sqrt(1.0 + scaled**2) * std)
    return weights


def _of_priors(unknowns: Unknowns, prior: UnitPrior, lever: LeverPrior) -> tuple[Array, Array]:
    """(information (16, 16), gradient (16,))."""
    information, pull = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS)
    for at, value, std in (
        (RATE_BIAS, unknowns.rate_bias_radps, prior.rate_bias_radps),
        (FORCE_BIAS, unknowns.force_bias_mps2, prior.force_bias_mps2),
    ):
        information[at, at] += np.eye(3) / std**2
        pull[at] += value / std**2
    size = float(np.linalg.norm(unknowns.gravity_mps2))
    down = unknowns.gravity_mps2 / size
    information[13:, 13:] += np.outer(down, down) / prior.gravity_mps2**2
    pull[13:] += (size - GRAVITY_MPS2) / prior.gravity_mps2**2 * down
    held = np.eye(3) / lever.wide_m**2 + lever.directions.T @ lever.directions / lever.kept_m**2
    information[LEVER, LEVER] += held
    pull[LEVER] += held @ (unknowns.lever_m - lever.value_m)
    return information, pull


def _blocks(lidar: LidarMotion, windows: Windows, block_s: float) -> np.ndarray:
    """(w,) the stretch of time in which each window begins."""
    begins = np.concatenate((windows.pairs[:, 0], windows.triples[:, 0]))
    return np.asarray((lidar.stamps_s[begins] / block_s).astype(np.int64))


def _covariance(slopes: Array, values: Array, known: Array, blocks: np.ndarray) -> Array:
    """Of the unknowns: by windows that err alone, or by how blocks of them disagree if that is more."""
    pulls = np.einsum("nij,ni->nj", slopes, values)
    of_blocks = np.zeros((int(blocks.max()) + 1, UNKNOWNS))
    np.add.at(of_blocks, blocks, pulls)
    count = len(np.unique(blocks))
    apart = of_blocks.T @ of_blocks * (count / max(1, count - 1))
    # Each unknown in its own size, or the inverse loses digits.
    scale = 1.0 / np.sqrt(np.diag(np.einsum("nij,nik->jk", slopes, slopes) + known))
    own = np.einsum("nij,nik->jk", slopes, slopes) * np.outer(scale, scale)
    inverse = np.linalg.inv(own + known * np.outer(scale, scale))
    together = inverse @ (apart * np.outer(scale, scale)) @ inverse
    overlap = _TOGETHER
    alike = inverse @ (own * overlap + known * np.outer(scale, scale)) @ inverse
    larger = np.maximum(np.diag(together), np.diag(alike)) / np.diag(alike)
    grown = alike * np.sqrt(np.outer(larger, larger))
    result: Array = grown * np.outer(scale, scale)
    return result
