"""The outlines that a board can have: how wide each is at every height above its lowest point."""

import math
from typing import Literal

import numpy as np

from contract.geometry import Array

OutlineKind = Literal["octagon", "point_down", "point_up", "plate", "disc", "diamond"]
OUTLINES: tuple[OutlineKind, ...] = ("octagon", "point_down", "point_up", "plate", "disc", "diamond")
# Heights are told apart by this step.
STEP_M = 0.025
# The lowest point of a board may be so high above the plane of the vehicle's wheels.
BOTTOMS_M: Array = np.arange(0.6, 3.4, STEP_M)
# Octagon: between opposite sides (MUTCD, GB 5768: 0.6 m to 0.9 m; smaller ones are not told from discs);
# triangles: a side; plate: width, of any height; disc: diameter; diamond: diagonal.
_SIZES_M: dict[OutlineKind, tuple[float, float]] = {
    "octagon": (0.7, 0.95),
    "point_down": (0.7, 1.25),
    "point_up": (0.7, 1.25),
    "plate": (0.2, 1.2),
    "disc": (0.4, 0.65),
    "diamond": (0.8, 1.3),
}
_SIZE_STEP_M = 0.05
_ROWS = 56
_SQRT3_2 = math.sqrt(3.0) / 2.0
_SIDE = math.sqrt(2.0) - 1.0


def chord_m(outline: OutlineKind, size_m: float, above_m: Array) -> Array:
    """(n,) the width of an outline at heights (n,) above its lowest point; 0.0 above and below it."""
    a = above_m
    if outline == "plate":
        return np.where(a >= 0.0, size_m, 0.0)
    if outline == "octagon":
        inward = np.minimum(a, size_m - a)
        return np.where(inward >= 0.0, np.minimum(size_m, _SIDE * size_m + 2.0 * inward), 0.0)
    if outline == "disc":
        return 2.0 * np.sqrt(np.maximum(a * (size_m - a), 0.0))
    if outline == "diamond":
        return 2.0 * np.maximum(np.minimum(a, size_m - a), 0.0)
    tall_m = _SQRT3_2 * size_m
    from_point = a if outline == "point_down" else tall_m - a
    return np.where((a >= 0.0) & (a <= tall_m), from_point / _SQRT3_2, 0.0)


def _hypotheses() -> tuple[Array, np.ndarray, Array]:
    """((h, rows) widths by height, (h,) index into OUTLINES, (h,) sizes)."""
    heights: Array = STEP_M * np.arange(-4.0, _ROWS - 4.0)
    widths, kinds, sizes = [], [], []
    for number, outline in enumerate(OUTLINES):
        low, high = _SIZES_M[outline]
        for size in np.arange(low, high + 1e-9, _SIZE_STEP_M):
            widths.append(chord_m(outline, float(size), heights))
            kinds.append(number)
            sizes.append(float(size))
    return np.array(widths), np.array(kinds), np.array(sizes)


WIDTHS_M, KINDS, SIZES_M = _hypotheses()


def widths_at(height_m: float) -> Array:
    """(h, bottoms) the width that each outline, with its lowest point at each of BOTTOMS_M, has at a height.

    A plate is as high as it needs to be.
    """
    rows = np.rint((height_m - BOTTOMS_M) / STEP_M).astype(np.int64) + 4
    inside = (rows >= 0) & (rows < _ROWS)
    widths: Array = np.where(inside, WIDTHS_M[:, np.clip(rows, 0, _ROWS - 1)], 0.0)
    return widths
