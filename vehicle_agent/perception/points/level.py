"""The ground below a lidar whose height and tilt are not known."""

import numpy as np

from contract.geometry import Array

# The ring around the sensor in which the ground is looked for, and the cells whose lowest returns count.
_RING_M = (2.5, 18.0)
_CELL_M = 0.5
_BIN_M = 0.1
# Lowest returns within this of the plane belong to it, in each round.
_NEAR_M = (0.5, 0.3, 0.15)
# A sensor looks down on the ground: nothing nearer below it counts.
_HEIGHT_M_MIN = 0.3
_CELLS_MIN = 12


class NoGroundError(ValueError):
    """Too few returns around the sensor for a ground."""


def ground_plane(points_sensor: np.ndarray) -> Array:
    """(3,) a, b, c of the ground around the sensor, z = a + b x + c y in its frame (z up).

    points_sensor (n, 3). Of the lowest returns of small cells most lie on the ground. The plane begins
    level at the height where most are, and is then fitted to those near it. Raises NoGroundError.
    """
    lowest = _lowest_returns(np.asarray(points_sensor, dtype=np.float64))
    if len(lowest) < _CELLS_MIN:
        raise NoGroundError(f"{len(lowest)} cells with returns below the sensor; {_CELLS_MIN} are needed")
    bins = np.floor(lowest[:, 2] / _BIN_M).astype(np.int64)
    counts = np.bincount(bins - bins.min())
    # Three bins together, so that a height between two of them is found, too.
    around = np.convolve(counts, np.ones(3), "same")
    plane: Array = np.array([(int(np.argmax(around)) + bins.min() + 0.5) * _BIN_M, 0.0, 0.0])
    rows = np.column_stack((np.ones(len(lowest)), lowest[:, :2]))
    for near_m in _NEAR_M:
        on_it = np.abs(lowest[:, 2] - rows @ plane) < near_m
        if np.count_nonzero(on_it) < _CELLS_MIN:
            break
        plane = np.linalg.lstsq(rows[on_it], lowest[on_it, 2], rcond=None)[0]
    return plane


def above_plane(points_sensor: np.ndarray, plane: Array) -> np.ndarray:
    """(n, 3) float32 the points with z from the plane: a base frame below the sensor, for small tilts."""
    points = np.array(points_sensor, dtype=np.float32)
    points[:, 2] -= (plane[0] + points[:, 0] * plane[1] + points[:, 1] * plane[2]).astype(np.float32)
    return points


def _lowest_returns(points: Array) -> Array:
    """(k, 3) the lowest return of each cell of the ring."""
    ranges = np.hypot(points[:, 0], points[:, 1])
    with np.errstate(invalid="ignore"):
        chosen = (ranges > _RING_M[0]) & (ranges < _RING_M[1]) & (points[:, 2] < -_HEIGHT_M_MIN)
    near = points[chosen]
    across = np.floor((near[:, :2] + _RING_M[1]) / _CELL_M).astype(np.int64)
    cells = across[:, 0] * 1_000 + across[:, 1]
    order = np.lexsort((near[:, 2], cells))
    first = np.unique(cells[order], return_index=True)[1]
    lowest: Array = near[order[first]]
    return lowest
