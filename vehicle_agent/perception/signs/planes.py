"""The fifth stage of GEM, section VI: the plane of a board, and whether it faces the vehicle."""

import itertools
import math

import msgspec
import numpy as np

from contract.geometry import Array, BoolArray

# All pairs of so many points are tried, which stand for the whole board.
_SAMPLES = 20


class UprightPlane(msgspec.Struct, frozen=True):
    """normal (2,) of length 1, horizontal, towards the vehicle; offset_m: normal . p of its points;
    inliers (n,) of the points that were given.
    """

    normal: Array
    offset_m: float
    inliers: BoolArray


def upright_plane(points: Array, origin: Array, tolerance_m: float) -> UprightPlane | None:
    """The upright plane that most of the points (n, 3) lie on; None for points in one place.

    A distant board is met by one or two rings, which do not define a plane in space. Boards stand upright, so
    two points do. All pairs of `_SAMPLES` points are tried, so nothing is drawn (SACSegmentation draws).
    origin (2,) of the sensor, base frame
    """
    plan = points[:, :2]
    # Samples spread over the board's width.
    spread = plan - plan.mean(axis=0)
    across = np.linalg.svd(spread, full_matrices=False)[2][0] if len(plan) > 1 else np.array([0.0, 1.0])
    order = np.argsort(spread @ across, kind="stable")
    chosen = order[np.unique(np.linspace(0, len(order) - 1, _SAMPLES).astype(np.int64))]
    pairs = np.array(list(itertools.combinations(chosen.tolist(), 2)), dtype=np.int64).reshape(-1, 2)
    along = plan[pairs[:, 1]] - plan[pairs[:, 0]]
    lengths = np.hypot(along[:, 0], along[:, 1])
    is_wide = lengths > 0.05
    pairs, along, lengths = pairs[is_wide], along[is_wide], lengths[is_wide]
    if not len(pairs):
        return None
    normals = np.column_stack((-along[:, 1], along[:, 0])) / lengths[:, None]
    offsets = np.sum(normals * plan[pairs[:, 0]], axis=1)
    misses = np.abs(plan @ normals.T - offsets)
    near = misses <= tolerance_m
    # Of planes with the same number of points, the one that is nearest to them.
    best = int(np.argmax(near.sum(axis=0) - np.where(near, misses, 0.0).sum(axis=0) / (1e3 * tolerance_m)))
    inliers = near[:, best]
    return _refined(points, inliers, origin)


def _refined(points: Array, inliers: BoolArray, origin: Array) -> UprightPlane | None:
    plan = points[inliers, :2]
    middle = plan.mean(axis=0)
    _, _, axes = np.linalg.svd(plan - middle, full_matrices=False)
    if len(axes) < 2:
        return None
    normal = axes[1]
    if normal @ (origin - middle) < 0.0:
        normal = -normal
    return UprightPlane(normal, float(normal @ middle), inliers)


def faces(plane: UprightPlane, middle: Array, origin: Array, facing_min: float) -> bool:
    """Whether the board faces back along the vehicle's axis, or towards the vehicle: a >= 0.9 in the paper.

    Beside a near board the line of sight is slanted; in a bend the axis is.
    """
    sight = origin - middle
    sight = sight / max(math.hypot(*sight), 1e-9)
    return max(-float(plane.normal[0]), float(plane.normal @ sight)) >= facing_min


def lean_ratio(points: Array) -> float:
    """How far the best plane through the points (n, 3) leans: vertical part of its normal, 0.0 upright.

    0.0 as well for points within 0.2 m of height, which do not tell.
    """
    if len(points) < 6 or float(np.ptp(points[:, 2])) < 0.2:
        return 0.0
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    return abs(float(axes[2, 2]))
