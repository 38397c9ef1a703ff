"""Submaps: a few metres of keyframes as one body of points, and the space that they saw to be free."""

import math

import msgspec
import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from vehicle_agent.localization.laser.dead_reckoning import Keyframe, joined
from vehicle_agent.localization.laser.pose_arrays import between
from vehicle_agent.localization.laser.surfaces import Surface

_UNKNOWN, _FREE, _OCCUPIED = 0, 1, 2
# Beams graze a wall for a while before they hit it.
_FREE_BEFORE_M = 0.3


class FreeSpace(msgspec.Struct, frozen=True):
    """cells (rows, columns) unknown, free or occupied, as the submap saw them, in the submap's frame."""

    cells: NDArray[np.uint8]
    origin_x_m: float
    origin_y_m: float
    cell_m: float


def joined_surface(poses: Array, surfaces: tuple[Surface, ...], anchor: Array) -> Surface:
    """The points of all these keyframes in the frame of the anchor pose."""
    relative = between(anchor, poses)
    points, normals = joined(
        tuple(Keyframe(pose, surface) for pose, surface in zip(relative, surfaces, strict=True))
    )
    return Surface(points, normals)


def thinned(surface: Surface, cell_m: float, reach_m: float) -> Surface:
    """At most one point, the first, in each cell, of those within reach of the frame's origin."""
    points, normals = surface.points_laser, surface.normals_laser
    near = np.flatnonzero(np.hypot(points[:, 0], points[:, 1]) < reach_m)
    cells = np.floor(points[near] / cell_m).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    kept = near[np.sort(first)]
    return Surface(points[kept], normals[kept])


def free_space(
    poses: Array, surfaces: tuple[Surface, ...], anchor: Array, cell_m: float, reach_m: float
) -> FreeSpace:
    """What the keyframes saw within reach of each, in the frame of the anchor pose."""
    relative = between(anchor, poses)
    whole = joined_surface(poses, surfaces, anchor).points_laser
    corners = np.concatenate([whole, relative[:, :2]])
    low = np.maximum(corners.min(axis=0), relative[:, :2].min(axis=0) - reach_m) - cell_m
    high = np.minimum(corners.max(axis=0), relative[:, :2].max(axis=0) + reach_m) + cell_m
    columns, rows = (int(count) + 1 for count in np.ceil((high - low) / cell_m))
    cells = np.zeros((rows, columns), dtype=np.uint8)
    for pose, surface in zip(relative, surfaces, strict=True):
        _trace(cells, surface.points_laser, pose, low[0], low[1], cell_m, reach_m)
    _mark_occupied(cells, whole, low[0], low[1], cell_m)
    return FreeSpace(cells, float(low[0]), float(low[1]), cell_m)


def contradicting_ratio(points: Array, free: FreeSpace) -> tuple[float, float]:
    """(share of the points in known space that lie where it is free, share of all points in known space).

    points (n, 2) in the frame of `free`
    """
    columns = np.floor((points[:, 0] - free.origin_x_m) / free.cell_m).astype(np.int64)
    rows = np.floor((points[:, 1] - free.origin_y_m) / free.cell_m).astype(np.int64)
    inside = (rows >= 0) & (rows < free.cells.shape[0]) & (columns >= 0) & (columns < free.cells.shape[1])
    seen = free.cells[rows[inside], columns[inside]]
    known = int((seen != _UNKNOWN).sum())
    if not known:
        return 1.0, 0.0
    return float((seen == _FREE).sum()) / known, known / len(points)


@njit(cache=True)
def _trace(
    cells: NDArray[np.uint8],
    points: Array,
    pose: Array,
    origin_x_m: float,
    origin_y_m: float,
    cell_m: float,
    reach_m: float,
) -> None:
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    rows, columns = cells.shape
    for i in range(points.shape[0]):
        dx = cos * points[i, 0] - sin * points[i, 1]
        dy = sin * points[i, 0] + cos * points[i, 1]
        distance = math.hypot(dx, dy)
        length = min(distance - _FREE_BEFORE_M, reach_m)
        if length <= 0.0:
            continue
        steps = int(length / (0.7 * cell_m))
        for k in range(steps):
            along = k * 0.7 * cell_m / distance
            c = math.floor((pose[0] + along * dx - origin_x_m) / cell_m)
            r = math.floor((pose[1] + along * dy - origin_y_m) / cell_m)
            if 0 <= r < rows and 0 <= c < columns:
                cells[r, c] = _FREE


@njit(cache=True)
def _mark_occupied(
    cells: NDArray[np.uint8], points: Array, origin_x_m: float, origin_y_m: float, cell_m: float
) -> None:
    """Also the cells around a point: a match is off by some centimetres."""
    rows, columns = cells.shape
    for i in range(points.shape[0]):
        c = math.floor((points[i, 0] - origin_x_m) / cell_m)
        r = math.floor((points[i, 1] - origin_y_m) / cell_m)
        for near_r in range(max(0, r - 1), min(rows, r + 2)):
            for near_c in range(max(0, c - 1), min(columns, c + 2)):
                cells[near_r, near_c] = _OCCUPIED
