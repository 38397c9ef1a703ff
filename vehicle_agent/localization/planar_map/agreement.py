"""How a scan agrees with the map at a pose, beam by beam, where things hide what is behind them."""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.localization.monte_carlo.likelihood_field import Float32Array

# Entries of what is counted.
ON_WALL, THROUGH_WALL, SHORT, BESIDE_MAP = range(4)
# A cell of a wall; and near enough to one.
_WALL, _NEAR = 0.999, 0.3


@njit(cache=True)
def counted_beams(
    points: Array, pose: Array, hit: Float32Array, origin_x_m: float, origin_y_m: float, cell_m: float,
    clear_m: float,
) -> Array:  # fmt: skip
    """(4,) beams that end on a wall of the map, that passed through one, that end short of all, outside.

    points   (m, 2) ends of the beams in the laser's frame; pose (3,) of the laser in the map frame
    hit      (rows, columns) nearness of walls, of `LikelihoodField`
    clear_m  a wall within so much of the beam's end, or of the laser, is not passed through
    """
    counts = np.zeros(4)
    rows, columns = hit.shape
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for i in range(points.shape[0]):
        dx, dy = cos * points[i, 0] - sin * points[i, 1], sin * points[i, 0] + cos * points[i, 1]
        length = math.hypot(dx, dy)
        column = math.floor((pose[0] + dx - origin_x_m) / cell_m)
        row = math.floor((pose[1] + dy - origin_y_m) / cell_m)
        if not (0 <= row < rows and 0 <= column < columns):
            counts[BESIDE_MAP] += 1.0
            continue
        if hit[row, column] > _NEAR:
            counts[ON_WALL] += 1.0
            continue
        steps = int((length - 2.0 * clear_m) / cell_m)
        is_through = False
        for step in range(max(0, steps)):
            share = (clear_m + step * cell_m) / length
            column = math.floor((pose[0] + share * dx - origin_x_m) / cell_m)
            row = math.floor((pose[1] + share * dy - origin_y_m) / cell_m)
            if 0 <= row < rows and 0 <= column < columns and hit[row, column] > _WALL:
                is_through = True
                break
        counts[THROUGH_WALL if is_through else SHORT] += 1.0
    return counts
