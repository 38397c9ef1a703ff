"""What a place looks like from above, whatever the heading: heights over rings and sectors.

Scan Context (Kim and Kim 2018): the greatest height in each cell of a polar grid; its rings alone find
candidates, the shift of sectors at which two grids agree best is the difference of headings.
"""

import math

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from contract.geometry import Array

RINGS, SECTORS = 20, 60
REACH_M = 50.0
# Above the ground; lower is road, and higher is seen from near alone.
_HEIGHT_M_MIN, _HEIGHT_M_MAX = 0.3, 6.0


@njit(cache=True)
def descriptor(points: Array, ground_m: float) -> Array:
    """(RINGS, SECTORS) of points (m, 3) whose z axis is up and whose ground is at z = ground_m."""
    grid = np.zeros((RINGS, SECTORS))
    for i in range(points.shape[0]):
        height = min(points[i, 2] - ground_m, _HEIGHT_M_MAX)
        distance = math.hypot(points[i, 0], points[i, 1])
        if height < _HEIGHT_M_MIN or distance >= REACH_M:
            continue
        ring = int(distance / REACH_M * RINGS)
        sector = int((math.atan2(points[i, 1], points[i, 0]) + math.pi) / (2.0 * math.pi) * SECTORS) % SECTORS
        grid[ring, sector] = max(grid[ring, sector], height)
    return grid


@njit(cache=True)
def distance_of(first: Array, second: Array) -> tuple[float, int]:
    """(1 - mean cosine of the columns at the best shift, the shift by which second's sectors are rolled)."""
    best, best_shift = 2.0, 0
    for shift in range(SECTORS):
        total, count = 0.0, 0
        for sector in range(SECTORS):
            product, a2, b2 = 0.0, 0.0, 0.0
            other = (sector - shift) % SECTORS
            for ring in range(RINGS):
                a, b = first[ring, sector], second[ring, other]
                product += a * b
                a2 += a * a
                b2 += b * b
            if a2 > 0.0 or b2 > 0.0:
                count += 1
                if a2 > 0.0 and b2 > 0.0:
                    total += product / math.sqrt(a2 * b2)
        if count > 0 and 1.0 - total / count < best:
            best, best_shift = 1.0 - total / count, shift
    return best, best_shift


def similar_places(
    grids: Array, apart: int, neighbours: int, distance_max: float
) -> list[tuple[int, int, float]]:
    """(newer, older, yaw of the newer in the older's frame) of grids (k, RINGS, SECTORS) that look alike.

    apart: at least so many lie between the two; neighbours: candidates by rings that are compared
    """
    keys = (grids > 0.0).mean(axis=2) * 4.0 + grids.mean(axis=2) / _HEIGHT_M_MAX
    tree = cKDTree(keys)
    found = []
    for number in range(apart, len(grids)):
        _, near = tree.query(keys[number], k=min(len(grids), neighbours + 2 * apart))
        scored = []
        for other in [int(i) for i in near if i <= number - apart][:neighbours]:
            distance, shift = distance_of(grids[other], grids[number])
            scored.append((distance, other, shift))
        for distance, other, shift in sorted(scored)[:1]:
            if distance <= distance_max:
                found.append((number, other, math.remainder(2.0 * math.pi * shift / SECTORS, math.tau)))
    return found
