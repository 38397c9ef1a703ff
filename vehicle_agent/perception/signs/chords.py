"""The chords in which a lidar's rings cut a board."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from contract.geometry import Array

# Neighbours on one ring: along it they are up to 9 cm apart at 25 m, across it they are level.
_ALONG_M, _ACROSS_M = 0.16, 0.05
_POINTS_MIN = 3


def chords_of(points: Array, normal_yaw_rad: float, step_ratio: float, range_m: float) -> Array:
    """(k, 4) width of each chord, height of its left and of its right end, standard deviation of the width.

    points       (n, 3) of one board in one scan
    step_ratio   angle between two firings of a ring, rad. A ring's last returns are on average half a step
                 before the board's edges
    Rings of a tilted lidar cut a board at a slant, so both ends have heights of their own.
    """
    across = points[:, :2] @ np.array([-np.sin(normal_yaw_rad), np.cos(normal_yaw_rad)])
    scaled = np.column_stack((across / _ALONG_M, points[:, 2] / _ACROSS_M))
    pairs = cKDTree(scaled).query_pairs(1.0, output_type="ndarray")
    shape = (len(points), len(points))
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=shape)
    count, labels = connected_components(graph, directed=False)
    step_m = step_ratio * range_m
    rows = []
    for k in range(count):
        members = np.flatnonzero(labels == k)
        if len(members) < _POINTS_MIN:
            continue
        left, right = members[np.argmin(across[members])], members[np.argmax(across[members])]
        width_m = float(across[right] - across[left]) + step_m
        # Both ends are uniform within a step.
        deviation_m = float(np.hypot(0.41 * step_m, 0.015))
        rows.append((width_m, float(points[left, 2]), float(points[right, 2]), deviation_m))
    return np.array(rows).reshape(-1, 4)
