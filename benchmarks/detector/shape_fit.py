"""The peer of the detector: clusters of returns, a rectangle around each, and a kind by its size."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree

from contract.geometry import Array
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE
from workshop.detector.average_precision import FoundBoxes

_CELL_M = 0.1
_NEAR_M = 0.45
_POINTS_MIN = 4
# Length and width of a kind's usual body, m.
_USUAL_M = {PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.75, 0.6), VEHICLE: (4.4, 1.8)}
_USUAL_HEIGHTS_M = {PEDESTRIAN: 1.7, CYCLIST: 1.7, VEHICLE: 1.5}
# Two clusters are the same body where one is this near to the other's place by the turn before.
_MATCH_M = 1.2


def found_by_shape(points: Array, is_older: NDArray[np.bool_], older_s: float) -> FoundBoxes:
    """Boxes of clusters of returns (n, 4): x, y, height, intensity.

    A cluster up to 1.1 m long is a person, up to 2.4 m and narrow a cyclist, up to 9 m a vehicle, if as high.
    A side that is seen in part is made as long as usual, away from the sensor. The velocity is the shift
    since the nearest cluster of the turn before. The score is how near size and height are to the usual.
    """
    newer = _clusters(points[~is_older])
    before = [cluster[:, :2].mean(axis=0) for cluster in _clusters(points[is_older])]
    tree = cKDTree(np.array(before)) if before else None
    kinds, scores, boxes = [], [], []
    for cluster in newer:
        box = _rectangle(cluster[:, :2])
        kind = _kind(box, cluster[:, 2])
        if kind is None:
            continue
        score = _score(box, cluster[:, 2].max(), kind) * (1.0 - 1.0 / (1.0 + 0.2 * len(cluster)))
        box = _completed(box, kind)
        velocity = np.full(2, np.nan)
        if tree is not None:
            apart, nearest = tree.query(cluster[:, :2].mean(axis=0))
            if apart < _MATCH_M:
                velocity = (cluster[:, :2].mean(axis=0) - before[int(nearest)]) / older_s
        kinds.append(kind)
        scores.append(score)
        boxes.append(np.array([*box, cluster[:, 2].max(), *velocity]))
    return FoundBoxes(
        np.array(kinds, dtype=np.int64), np.array(scores), np.array(boxes, dtype=np.float64).reshape(-1, 8)
    )


def _clusters(points: Array) -> list[Array]:
    """Returns whose squares of 0.1 m are within 0.45 m of each other."""
    if not len(points):
        return []
    squares, square_of = np.unique(
        np.floor(points[:, :2] / _CELL_M).astype(np.int64), axis=0, return_inverse=True
    )
    pairs = cKDTree(squares * _CELL_M).query_pairs(_NEAR_M, output_type="ndarray")
    n = len(squares)
    linked = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    label = connected_components(linked, directed=False)[1][square_of.ravel()]
    order = np.argsort(label, kind="stable")
    parts = np.split(points[order], np.flatnonzero(np.diff(label[order])) + 1)
    return [part for part in parts if len(part) >= _POINTS_MIN]


def _rectangle(points: Array) -> Array:
    """(5,) x, y, yaw, length, width whose sides are nearest to the points (Zhang et al. 2017, closeness)."""
    try:
        hull = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        hull = points
    best, chosen = np.inf, (0.0, 0.0, 0.0, 0.1, 0.1)
    sample = points[:: max(1, len(points) // 100)]
    for angle in np.arange(0.0, 0.5 * np.pi, np.radians(3.0)):
        axis = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        low, high = (hull @ axis.T).min(axis=0), (hull @ axis.T).max(axis=0)
        turned = sample @ axis.T
        side = np.minimum(turned - low, high - turned).min(axis=1)
        cost = float(np.maximum(side, 0.03).mean() + 0.02 * np.prod(np.maximum(high - low, 0.1)))
        if cost < best:
            best = cost
            middle = 0.5 * (low + high) @ axis
            chosen = (middle[0], middle[1], angle, high[0] - low[0], high[1] - low[1])
    x, y, yaw, length, width = chosen
    if width > length:
        length, width, yaw = width, length, yaw + 0.5 * np.pi
    return np.array([x, y, yaw, max(length, 0.1), max(width, 0.1)])


def _kind(box: Array, heights_m: Array) -> int | None:
    length, width, top = box[3], box[4], heights_m.max()
    if length <= 1.1 and top >= 0.8 and length >= 0.25:
        return PEDESTRIAN
    if length <= 2.4 and width <= 1.0 and top >= 0.9:
        return CYCLIST
    if 1.3 <= length <= 9.0 and width <= 3.0 and top >= 0.6:
        return VEHICLE
    return None


def _score(box: Array, top_m: float, kind: int) -> float:
    """0 to 1: 1 for the usual length, width and height; too small counts half, since it may be hidden."""
    off = 0.0
    for seen, usual in zip((box[3], box[4], top_m), (*_USUAL_M[kind], _USUAL_HEIGHTS_M[kind]), strict=True):
        ratio = np.log(max(float(seen), 0.05) / usual)
        off += abs(ratio) * (0.5 if ratio < 0.0 else 1.5)
    return float(np.exp(-off))


def _completed(box: Array, kind: int) -> Array:
    """The box with sides as long as usual, grown away from the sensor."""
    x, y, yaw, length, width = box
    usual_length, usual_width = _USUAL_M[kind]
    if kind == PEDESTRIAN:
        return np.array([x, y, yaw, usual_length, usual_width])
    if kind == VEHICLE and length < 2.5 and width < 2.5:
        # Its rear or front alone.
        yaw, length, width = yaw + 0.5 * np.pi, width, length
    for axis, usual in ((0, usual_length), (1, usual_width)):
        seen = length if axis == 0 else width
        if seen < usual:
            along = np.array([np.cos(yaw + 0.5 * np.pi * axis), np.sin(yaw + 0.5 * np.pi * axis)])
            away = np.sign(along @ np.array([x, y])) or 1.0
            x, y = np.array([x, y]) + 0.5 * (usual - seen) * away * along
            length, width = (usual, width) if axis == 0 else (length, usual)
    return np.array([x, y, yaw, length, width])
