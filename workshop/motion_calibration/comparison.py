"""What a pose of the unit, a clock offset and biases leave unexplained of a drive.

A pair of scans is turned as the integrated gyroscope says: r = Log(A^T X B X^T), A the lidar's turn, B the
unit's and X the rotation between both (the hand-eye equation A X = X B; Park and Martin 1994). A triple of
scans has a second difference of positions; the specific force, integrated twice, has it too, but for gravity.
Second differences make the speed at the window's begin drop out.
"""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from contract.transforms import rotation_of
from workshop.motion_calibration.drive import InertialDrive, LidarMotion
from workshop.motion_calibration.integration import integrate, rotation_vectors
from workshop.motion_calibration.windows import Windows

# Slots of the unknowns' steps.
TURN, LEVER, OFFSET, RATE_BIAS, FORCE_BIAS, GRAVITY = (
    slice(0, 3), slice(3, 6), slice(6, 7), slice(7, 10), slice(10, 13), slice(13, 16),
)  # fmt: skip
UNKNOWNS = 16


@dataclass(frozen=True, slots=True, eq=False)
class Unknowns:
    """rotation (3, 3) R_lidar_unit; lever_m (3,) of the unit in the lidar's frame; offset_s of the clocks.

    rate_bias_radps, force_bias_mps2 (3,) in the unit's frame; gravity_mps2 (3,) in the map's, pointing down
    """

    rotation: Array
    lever_m: Array
    offset_s: float
    rate_bias_radps: Array
    force_bias_mps2: Array
    gravity_mps2: Array

    def moved(self, step: Array) -> "Unknowns":
        """By a step (16,); the turn is about the lidar's axes."""
        return Unknowns(
            rotation_of(step[TURN]) @ self.rotation,
            self.lever_m + step[LEVER],
            self.offset_s + float(step[6]),
            self.rate_bias_radps + step[RATE_BIAS],
            self.force_bias_mps2 + step[FORCE_BIAS],
            self.gravity_mps2 + step[GRAVITY],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Integrals:
    """The unit's samples at the moments of the scans: rotations (n, 3, 3), positions (n, 3)."""

    rotations: Array
    positions: Array


def integrals(lidar: LidarMotion, unit: InertialDrive, unknowns: Unknowns) -> Integrals:
    """By the biases and the offset of the unknowns; NaN where the samples do not reach."""
    start_s = 1e-9 * (lidar.start_ns - unit.start_ns) - unknowns.offset_s
    rates, forces = unit.rates_radps - unknowns.rate_bias_radps, unit.forces_mps2 - unknowns.force_bias_mps2
    rotations, positions = integrate(unit.stamps_s, rates, forces, lidar.stamps_s + start_s)
    return Integrals(rotations, positions)


def turn_residuals(poses: Array, found: Integrals, rotation: Array, pairs: np.ndarray) -> Array:
    """(n, 3) rad in the lidar's frame."""
    first, second = pairs.T
    lidar = poses[first, :3, :3].transpose(0, 2, 1) @ poses[second, :3, :3]
    unit = found.rotations[first].transpose(0, 2, 1) @ found.rotations[second]
    return rotation_vectors(lidar.transpose(0, 2, 1) @ (rotation @ unit @ rotation.T))


def map_rotations(poses: Array, found: Integrals, rotation: Array, triples: np.ndarray) -> Array:
    """(m, 3, 3) R_map_start of each triple, the mean of its scans: a scan's own rotation has noise."""
    each = poses[:, :3, :3] @ rotation @ found.rotations.transpose(0, 2, 1)
    sums = np.concatenate((np.zeros((1, 3, 3)), np.cumsum(np.nan_to_num(each), axis=0)))
    u, _, vt = np.linalg.svd(sums[triples[:, 2] + 1] - sums[triples[:, 0]])
    u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    rotations: Array = u @ vt
    return rotations


def accelerations(stamps_s: Array, values: Array, triples: np.ndarray) -> Array:
    """(m, 3) second differences of values (n, 3) over triples, as accelerations."""
    i, j, k = triples.T
    ahead = (values[k] - values[j]) / (stamps_s[k] - stamps_s[j])[:, None]
    behind = (values[j] - values[i]) / (stamps_s[j] - stamps_s[i])[:, None]
    result: Array = (ahead - behind) / (0.5 * (stamps_s[k] - stamps_s[i]))[:, None]
    return result


def force_residuals(lidar: LidarMotion, found: Integrals, unknowns: Unknowns, triples: np.ndarray) -> Array:
    """(m, 3) m/s2 in the map's frame: the unit's acceleration by the lidar less that by its samples."""
    places = lidar.poses[:, :3, 3] + lidar.poses[:, :3, :3] @ unknowns.lever_m
    seen = accelerations(lidar.stamps_s, places, triples)
    felt = accelerations(lidar.stamps_s, found.positions, triples)
    turned = map_rotations(lidar.poses, found, unknowns.rotation, triples)
    residuals: Array = seen - np.einsum("nij,nj->ni", turned, felt) - unknowns.gravity_mps2
    return residuals


def residuals(
    lidar: LidarMotion, found: Integrals, unknowns: Unknowns, windows: Windows
) -> tuple[Array, Array]:
    """(turns (n, 3) rad, accelerations (m, 3) m/s2); `found` by the biases and the offset of the unknowns."""
    return (
        turn_residuals(lidar.poses, found, unknowns.rotation, windows.pairs),
        force_residuals(lidar, found, unknowns, windows.triples),
    )
