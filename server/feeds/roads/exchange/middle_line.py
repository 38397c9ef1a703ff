"""The middle of two bounds, and how wide what lies between them is."""

import math

import numpy as np

from contract.geometry import Array, arc_lengths

_SPACING_M = 0.5


def middle_of(left: Array, right: Array) -> tuple[Array, float]:
    """((n, 2) middle line about 0.5 m apart, median width in metres) of two bounds in one direction.

    Points at equal shares of both lengths are paired. In a loop that swings out on both sides this leaves the
    middle; `lanelet_roads` draws such a loop anew.
    """
    longest_m = max(float(arc_lengths(left)[-1]), float(arc_lengths(right)[-1]))
    count = max(2, math.ceil(longest_m / _SPACING_M) + 1)
    one, other = _evenly(left, count), _evenly(right, count)
    return (one + other) / 2.0, float(np.median(np.hypot(*(one - other).T)))


def _evenly(points: Array, count: int) -> Array:
    s = arc_lengths(points)
    wanted = np.linspace(0.0, float(s[-1]), count)
    even: Array = np.column_stack([np.interp(wanted, s, points[:, k]) for k in (0, 1)])
    return even
