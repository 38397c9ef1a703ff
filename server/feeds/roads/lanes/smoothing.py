"""A noisy or cornered line made drivable, moved no farther than it must be."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, arc_lengths, curvatures, project, resample

_STEP_M = 0.5
_LAST_REACH_M = 20.0
_GROWTH = 1.3
_ROUNDS = 24


def smooth(
    points: Array, curvature_max_1pm: float, *, held_m: float = 0.0, reach_m: float = 1.2
) -> Array | None:
    """(n, 2) points 0.5 m apart whose curvature stays under the limit, both ends kept; None if not found.

    A smoothing spline: least squares to the line against the squared third derivative, whose weight
    (a smoothing length, reach_m at first) grows only around the places that still bend too sharply.
    held_m  how much of both ends stays where it is, so that the headings there do too.
    """
    guide = resample(points, _STEP_M)
    if len(guide) < 8:
        return guide if _bends_less(guide, curvature_max_1pm) else None
    step_m = float(arc_lengths(guide)[-1]) / (len(guide) - 1)
    reach = np.full(len(guide), reach_m)
    held = 1 + math.floor(held_m / step_m + 0.01)
    for _ in range(_ROUNDS):
        line = _spline(guide, reach / step_m, held)
        sharp = np.abs(curvatures(line)) > curvature_max_1pm
        if not sharp.any():
            even: Array = resample(line, _STEP_M)
            return even
        grown = np.zeros(len(guide), dtype=bool)
        for i in np.flatnonzero(sharp):
            width = max(3, math.ceil(2.5 * reach[i] / step_m))
            grown[max(0, i - width) : i + width + 1] = True
        reach[grown] *= _GROWTH
        if reach.max() > _LAST_REACH_M:
            return None
    return None


@njit(cache=True)
def _spline(guide: Array, reach_steps: Array, held: int) -> Array:
    """Solve (W + D' L D) q = -D' L D g and return g + q; D takes third differences, W holds the ends.

    Solving for the corrections q keeps rounding errors far below the map's 0.1 mm, and doing it here
    instead of in LAPACK keeps them equal on every processor.
    """
    n = guide.shape[0]
    pattern = (-1.0, 3.0, -3.0, 1.0)
    band = np.zeros((n, 4))
    right = np.zeros((n, 2))
    for i in range(n):
        band[i, 0] = 1e6 if i < held or i >= n - held else 1.0
    for i in range(n - 3):
        stiffness = min(reach_steps[i], reach_steps[i + 3]) ** 6
        third = -guide[i] + 3.0 * guide[i + 1] - 3.0 * guide[i + 2] + guide[i + 3]
        for a in range(4):
            for c in range(2):
                right[i + a, c] -= stiffness * pattern[a] * third[c]
            for b in range(a, 4):
                band[i + a, b - a] += stiffness * pattern[a] * pattern[b]
    _solve_banded(band, right)
    right[0], right[n - 1] = 0.0, 0.0
    line: Array = guide + right
    return line


@njit(cache=True)
def _solve_banded(band: Array, right: Array) -> None:
    """Solve a symmetric positive definite system in place, LDL'. band[i, k] is the entry (i, i + k)."""
    n, width = band.shape
    for i in range(n):
        for k in range(1, min(width, n - i)):
            share = band[i, k] / band[i, 0]
            for m in range(k, min(width, n - i)):
                band[i + k, m - k] -= share * band[i, m]
            for c in range(right.shape[1]):
                right[i + k, c] -= share * right[i, c]
    for i in range(n - 1, -1, -1):
        for c in range(right.shape[1]):
            rest = right[i, c]
            for k in range(1, min(width, n - i)):
                rest -= band[i, k] * right[i + k, c]
            right[i, c] = rest / band[i, 0]


def _bends_less(points: Array, curvature_max_1pm: float) -> bool:
    return bool(np.all(np.abs(curvatures(points)) <= curvature_max_1pm))


def largest_deviation_m(points: Array, guide: Array) -> float:
    """How far points (n, 2) stray from the guide line (m, 2)."""
    s = arc_lengths(guide)
    return max(abs(float(project(guide, s, x, y, 0, len(guide))[1])) for x, y in points)
