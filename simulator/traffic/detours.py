"""The shortest way on foot round a rectangle: which corner to walk to next."""

import math

from numba import njit

# A way round that is shorter by this is worth turning back.
_BEGUN_M = 0.5
# So far beyond a corner people turn round it.
_ROUND_M = 0.05


@njit(cache=True)
def next_corner(
    x: float,
    y: float,
    heading: float,
    goal_x: float,
    goal_y: float,
    back: float,
    front: float,
    half: float,
) -> tuple[float, float]:
    """The corner of a rectangle to walk to first, on the shortest way round it to the goal.

    All in the rectangle's frame: x from back to front (m), y from -half to half (m), the heading in radians.
    A place a metre ahead where no corner is in sight.
    """
    best_m, to_x, to_y = math.inf, x + 1.0, y
    for corner in range(4):
        ahead, left = corner < 2, corner % 2 == 0
        cx, cy = (front if ahead else back), (half if left else -half)
        # A little beyond it, so that who has got there sees the next one.
        cx, cy = cx + (_ROUND_M if ahead else -_ROUND_M), cy + (_ROUND_M if left else -_ROUND_M)
        way_m = math.hypot(cx - x, cy - y)
        if way_m < _ROUND_M or crosses(x, y, cx, cy, back, front, half):
            continue
        # Of two ways that are as long, the one that they have begun.
        turn = math.cos(math.atan2(cy - y, cx - x) - heading)
        if crosses(cx, cy, goal_x, goal_y, back, front, half):
            along_m = 2.0 * (half + _ROUND_M) + math.hypot(goal_x - cx, goal_y + cy)
            beside_x = (back - _ROUND_M) if ahead else (front + _ROUND_M)
            beside_m = front - back + 2.0 * _ROUND_M + math.hypot(goal_x - beside_x, goal_y - cy)
            way_m += min(along_m, beside_m)
        else:
            way_m += math.hypot(goal_x - cx, goal_y - cy)
        way_m -= _BEGUN_M * turn
        if way_m < best_m:
            best_m, to_x, to_y = way_m, cx, cy
    return to_x, to_y


@njit(cache=True)
def crosses(x: float, y: float, to_x: float, to_y: float, back: float, front: float, half: float) -> bool:
    """Whether a straight way leads through the inside of a rectangle (base frame), not along its edge."""
    begin, end = 0.0, 1.0
    for axis in range(2):
        at, step = (x, to_x - x) if axis == 0 else (y, to_y - y)
        low, high = (back, front) if axis == 0 else (-half, half)
        low, high = low + 1e-3, high - 1e-3
        if abs(step) < 1e-9:
            if not low < at < high:
                return False
            continue
        first, last = (low - at) / step, (high - at) / step
        begin, end = max(begin, min(first, last)), min(end, max(first, last))
    return begin < end
