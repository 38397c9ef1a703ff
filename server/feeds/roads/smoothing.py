"""A noisy or cornered line made drivable, moved no farther than it must be."""

import math

import numpy as np
from scipy.linalg import solveh_banded

from contract.geometry import Array, arc_lengths, curvatures, project, resample

_STEP_M = 0.5
_FIRST_REACH_M = 1.2
_LAST_REACH_M = 20.0
_GROWTH = 1.3
_ROUNDS = 24


def smooth(points: Array, curvature_max_1pm: float, *, held_m: float = 0.0) -> Array | None:
    """(n, 2) points 0.5 m apart whose curvature stays under the limit, both ends kept; None if not found.

    A smoothing spline: least squares to the line against the squared third derivative, whose weight
    (a smoothing length) grows only around the places that still bend too sharply.
    held_m  how much of both ends stays where it is, so that the headings there do too.
    """
    guide = resample(points, _STEP_M)
    if len(guide) < 8:
        return guide if _bends_less(guide, curvature_max_1pm) else None
    step_m = float(arc_lengths(guide)[-1]) / (len(guide) - 1)
    reach = np.full(len(guide), _FIRST_REACH_M)
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


def _spline(guide: Array, reach_steps: Array, held: int) -> Array:
    """Solve (W + D' L D) p = W g for both coordinates; D takes third differences, W holds the ends."""
    n = len(guide)
    weight = np.ones(n)
    weight[:held] = weight[-held:] = 1e6
    stiffness = (np.minimum(reach_steps[:-3], reach_steps[3:])) ** 6
    bands = np.zeros((4, n))
    bands[0] = weight
    pattern = (-1.0, 3.0, -3.0, 1.0)
    for i, left in enumerate(pattern):
        for j, right in enumerate(pattern[i:], start=i):
            bands[j - i, i : i + n - 3] += stiffness * left * right
    solved: Array = solveh_banded(bands, weight[:, None] * guide, lower=True)
    solved[0], solved[-1] = guide[0], guide[-1]
    return solved


def _bends_less(points: Array, curvature_max_1pm: float) -> bool:
    return bool(np.all(np.abs(curvatures(points)) <= curvature_max_1pm))


def largest_deviation_m(points: Array, guide: Array) -> float:
    """How far points (n, 2) stray from the guide line (m, 2)."""
    s = arc_lengths(guide)
    return max(abs(float(project(guide, s, x, y, 0, len(guide))[1])) for x, y in points)
