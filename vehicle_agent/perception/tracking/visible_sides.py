"""The middle of an object of which a lidar sees the near sides only."""

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
