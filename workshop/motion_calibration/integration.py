"""The unit's samples, integrated to the moments of the scans."""

import numpy as np
from numba import njit

from contract.geometry import Array


@njit(cache=True)
def integrate(stamps_s: Array, rates_radps: Array, forces_mps2: Array, at_s: Array) -> tuple[Array, Array]:
    """(rotations (m, 3, 3) T_start_unit, positions (m, 3)) at the times at_s (m,), rising.

    stamps_s (n,) rising; rates_radps, forces_mps2 (n, 3) without their biases. The start is the unit at the
    first sample. The positions are the specific force integrated twice in the start's frame, gravity in it
    and from rest: only their second differences mean something. Rates and forces are linear between samples.
    Times before the first sample or after the last give NaN.
    """
    m = len(at_s)
    rotations = np.full((m, 3, 3), np.nan)
    positions = np.full((m, 3), np.nan)
    turned = np.eye(3)
    speed, place = np.zeros(3), np.zeros(3)
    k = 0
    while k < m and at_s[k] < stamps_s[0]:
        k += 1
    for i in range(len(stamps_s) - 1):
        span = stamps_s[i + 1] - stamps_s[i]
        first = turned @ forces_mps2[i].copy()
        while k < m and at_s[k] <= stamps_s[i + 1]:
            part = at_s[k] - stamps_s[i]
            share = part / span
            rate = rates_radps[i] + 0.5 * share * (rates_radps[i + 1] - rates_radps[i])
            here = turned @ _rotation(rate * part)
            force = here @ (forces_mps2[i] + share * (forces_mps2[i + 1] - forces_mps2[i]))
            rotations[k] = here
            positions[k] = place + speed * part + (2.0 * first + force) * (part * part / 6.0)
            k += 1
        turned = turned @ _rotation(0.5 * (rates_radps[i] + rates_radps[i + 1]) * span)
        last = turned @ forces_mps2[i + 1].copy()
        place = place + speed * span + (2.0 * first + last) * (span * span / 6.0)
        speed = speed + 0.5 * (first + last) * span
    return rotations, positions


@njit(cache=True)
def _rotation(vector_rad: Array) -> Array:
    """(3, 3) of a small rotation vector; Rodrigues with series, good to 1e-12 below 0.1 rad."""
    x, y, z = vector_rad
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    square = x * x + y * y + z * z
    a = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0))
    b = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0))
    rotation: Array = np.eye(3) + a * cross + b * (cross @ cross)
    return rotation


def rotation_vectors(rotations: Array) -> Array:
    """(n, 3) rad of rotations (n, 3, 3) below half a turn."""
    sines = 0.5 * np.stack(
        (
            rotations[:, 2, 1] - rotations[:, 1, 2],
            rotations[:, 0, 2] - rotations[:, 2, 0],
            rotations[:, 1, 0] - rotations[:, 0, 1],
        ),
        axis=1,
    )
    sine = np.linalg.norm(sines, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(rotations, axis1=1, axis2=2) - 1.0))
    vectors: Array = sines * np.where(sine > 1e-9, angle / np.maximum(sine, 1e-12), 1.0)[:, None]
    return vectors
