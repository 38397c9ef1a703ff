"""The middle of an object of which the lidars see some sides only."""

import math

import numpy as np

from contract.geometry import Array


def aligned_sizes(yaw: float, seen_yaw: float, seen_size: Array) -> Array:
    """(2,) length and width of a seen box along and across a known direction: the box may lie across it."""
    off = abs(math.remainder(seen_yaw - yaw, math.pi))
    return seen_size[:2] if off < 0.25 * math.pi else seen_size[1::-1]


def towards_far_side(middle: Array, viewpoint: Array, yaw: float, missing: Array) -> Array:
    """(2,) how far the middle is from that of the visible part, of which `missing` (2,) m are not seen.

    middle, viewpoint (2,) in the same frame; missing: of the length and of the width. The near sides are
    seen, so what is missing lies beyond them. An axis seen end on misses half on either side.
    """
    moved: Array = np.zeros(2)
    away = middle - viewpoint
    for axis, angle in ((0, yaw), (1, yaw + 0.5 * math.pi)):
        direction = np.array([math.cos(angle), math.sin(angle)])
        along = float(away @ direction)
        # Within half a metre of the middle line, both ends are as near.
        side = max(-1.0, min(1.0, along / 0.5))
        moved += 0.5 * side * missing[axis] * direction
    return moved


def towards_expected(middle: Array, expected: Array, yaw: float, missing: Array) -> Array:
    """(2,) how far the middle is from that of the visible part, where either end may be hidden.

    expected (2,) where the middle was thought to be: within what is missing (2,) it may well be there
    """
    moved: Array = np.zeros(2)
    off = expected - middle
    for axis, angle in ((0, yaw), (1, yaw + 0.5 * math.pi)):
        direction = np.array([math.cos(angle), math.sin(angle)])
        half = 0.5 * missing[axis]
        moved += min(half, max(-half, float(off @ direction))) * direction
    return moved


def reaches_into(pose: Array, size: Array, area: tuple[float, float, float]) -> bool:
    """Whether a box comes into an area of the base frame: x from, x to, and how far to either side.

    pose (3,), size (2+,) length and width. Seen from the area's axes, as if the box lay along them.
    """
    cos, sin = abs(math.cos(pose[2])), abs(math.sin(pose[2]))
    reach_x, reach_y = 0.5 * (cos * size[0] + sin * size[1]), 0.5 * (sin * size[0] + cos * size[1])
    begin, end, side = area
    return bool(pose[0] + reach_x > begin and pose[0] - reach_x < end and abs(pose[1]) - reach_y < side)
