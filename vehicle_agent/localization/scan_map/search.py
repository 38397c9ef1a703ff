"""Where in a window around a lost vehicle a scan may lie: a lattice of poses, scored on a grid of the map.

The lattice's step is the grid's cell, so that a shift of the pose is a shift of indices and all poses take a
few milliseconds (correlative scan matching, Olson 2009, "Real-time correlative scan matching", section III).
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array, Pose2
from vehicle_agent.localization.odometry.voxel_map import Array32
from vehicle_agent.localization.scan_map.surfel_index import SurfelIndex

Grid = NDArray[np.uint8]
_BELOW_M, _ABOVE_M = 2.0, 14.0
# What a point counts in the element's own cell, beside it, and two cells away.
_NEAR = (4, 2, 1)


def likely_poses(
    points_base: Array, index: SurfelIndex, centre: Pose2, ground_m: float,
    window: tuple[float, float, float], count: int,
) -> list[Pose2]:  # fmt: skip
    """The best poses of a window, at most `count`, each more than 1 m or 0.1 rad from better ones.

    points_base (n, 3): of things above the road, from the axle's centre on the ground
    window  half its edge, m; half its turn and the step of turns, rad
    """
    half_m, half_rad, step_rad = window
    cell_m = index.voxel_m
    steps, turns = round(half_m / cell_m), round(half_rad / step_rad)
    reach = math.ceil(float(np.hypot(points_base[:, 0], points_base[:, 1]).max()) / cell_m) + steps + 2
    corner = np.array([centre.x_m - reach * cell_m, centre.y_m - reach * cell_m, ground_m - _BELOW_M])
    shape = (2 * reach + 1, 2 * reach + 1, round((_ABOVE_M + _BELOW_M) / cell_m))
    grid = _grid_of(index.elements[index.keys != -1], corner, cell_m, shape)
    yaws: Array = centre.yaw_rad + step_rad * np.arange(-turns, turns + 1, dtype=np.float64)
    place = np.array([centre.x_m, centre.y_m, ground_m]) - corner
    scores = _scores_of(points_base, yaws, place, cell_m, steps, grid)
    found: list[tuple[Pose2, int]] = []
    for at in np.argsort(-scores, axis=None, kind="stable")[: 400 * count].tolist():
        turn, ix, iy = np.unravel_index(at, scores.shape)
        pose = Pose2(
            centre.x_m + cell_m * float(ix - steps),
            centre.y_m + cell_m * float(iy - steps),
            float(yaws[turn]),
        )
        if all(_is_apart(pose, turn, other, k, step_rad) for other, k in found):
            found.append((pose, int(turn)))
            if len(found) == count:
                break
    return [pose for pose, _ in found]


def _is_apart(pose: Pose2, turn: int, other: Pose2, other_turn: int, step_rad: float) -> bool:
    far = math.hypot(pose.x_m - other.x_m, pose.y_m - other.y_m) > 1.0
    return far or abs(turn - other_turn) * step_rad > 0.1


@njit(cache=True)
def _grid_of(elements: Array32, corner: Array, cell_m: float, shape: tuple[int, int, int]) -> Grid:
    grid = np.zeros(shape, dtype=np.uint8)
    for i in range(elements.shape[0]):
        x = math.floor((elements[i, 0] - corner[0]) / cell_m)
        y = math.floor((elements[i, 1] - corner[1]) / cell_m)
        z = math.floor((elements[i, 2] - corner[2]) / cell_m)
        # Level elements are road and roofs.
        if abs(elements[i, 5]) > 0.9 or not (
            2 <= x < shape[0] - 2 and 2 <= y < shape[1] - 2 and 1 <= z < shape[2] - 1
        ):
            continue
        for a in range(-2, 3):
            for b in range(-2, 3):
                value = _NEAR[max(abs(a), abs(b))]
                for c in range(-1, 2):
                    grid[x + a, y + b, z + c] = max(grid[x + a, y + b, z + c], value)
    return grid


@njit(cache=True)
def _scores_of(
    points: Array, yaws: Array, place: Array, cell_m: float, steps: int, grid: Grid
) -> NDArray[np.int64]:
    """(turns, 2 * steps + 1, 2 * steps + 1) of poses around a place (3,) in the grid's frame."""
    side = 2 * steps + 1
    scores = np.zeros((len(yaws), side, side), dtype=np.int64)
    for turn in range(len(yaws)):
        cos, sin = math.cos(yaws[turn]), math.sin(yaws[turn])
        for i in range(points.shape[0]):
            x = math.floor((place[0] + cos * points[i, 0] - sin * points[i, 1]) / cell_m)
            y = math.floor((place[1] + sin * points[i, 0] + cos * points[i, 1]) / cell_m)
            z = math.floor((place[2] + points[i, 2]) / cell_m)
            if not 0 <= z < grid.shape[2]:
                continue
            for a in range(side):
                for b in range(side):
                    scores[turn, a, b] += grid[x + a - steps, y + b - steps, z]
    return scores
