"""A first rotation by the turns, and by the forces of all headings about their axis; a first lever arm."""

import math

import numpy as np

from contract.geometry import Array
from contract.transforms import rotation_of
from workshop.calibration.matching import kabsch
from workshop.motion_calibration.comparison import (
    Integrals,
    Unknowns,
    accelerations,
    integrals,
    map_rotations,
)
from workshop.motion_calibration.drive import InertialDrive, LidarMotion
from workshop.motion_calibration.integration import rotation_vectors
from workshop.motion_calibration.windows import Windows

_HEADINGS = 36


def first_guess(lidar: LidarMotion, unit: InertialDrive, offset_s: float, windows: Windows) -> Unknowns:
    """Of a drive whose turns may all be about one axis: the rotation about it is found by the forces."""
    zero = np.zeros(3)
    found = integrals(lidar, unit, Unknowns(np.eye(3), zero, offset_s, zero, zero, zero))
    first, second = windows.pairs.T
    seen = rotation_vectors(lidar.poses[first, :3, :3].transpose(0, 2, 1) @ lidar.poses[second, :3, :3])
    felt = rotation_vectors(found.rotations[first].transpose(0, 2, 1) @ found.rotations[second])
    start = kabsch(felt, seen)
    axis = _main_axis(seen)
    best: tuple[float, Unknowns] | None = None
    for number in range(_HEADINGS):
        rotation = rotation_of(2.0 * math.pi * number / _HEADINGS * axis) @ start
        cost, guess = _explained(lidar, found, rotation, offset_s, windows)
        if best is None or cost < best[0]:
            best = cost, guess
    assert best is not None
    return best[1]


def _main_axis(vectors: Array) -> Array:
    """(3,) unit vector about which most of the turns are."""
    _, directions = np.linalg.eigh(vectors.T @ vectors)
    axis: Array = directions[:, -1]
    return axis


def _explained(
    lidar: LidarMotion, found: Integrals, rotation: Array, offset_s: float, windows: Windows
) -> tuple[float, Unknowns]:
    """The mean absolute deviation (m/s2) that lever arm and gravity leave at this rotation; and these.

    Both enter linearly: a = g + felt - (second difference of the lidar's rotation) lever.
    """
    triples = windows.triples
    seen = accelerations(lidar.stamps_s, lidar.poses[:, :3, 3], triples)
    felt = accelerations(lidar.stamps_s, found.positions, triples)
    felt = np.einsum("nij,nj->ni", map_rotations(lidar.poses, found, rotation, triples), felt)
    columns = [accelerations(lidar.stamps_s, lidar.poses[:, :3, axis], triples) for axis in range(3)]
    matrix = np.zeros((len(triples), 3, 6))
    matrix[:, :, :3] = -np.stack(columns, axis=2)
    matrix[:, :, 3:] = np.eye(3)
    flat = matrix.reshape(-1, 6)
    wanted = (seen - felt).ravel()
    # A direction of the lever arm that does not matter stays 0.
    values = np.linalg.lstsq(flat, wanted, rcond=1e-3)[0]
    left = float(np.mean(np.abs(wanted - flat @ values)))
    return left, Unknowns(rotation, values[:3], offset_s, np.zeros(3), np.zeros(3), values[3:])
