"""The drivable area of the map, narrowed where the vehicle sees a kerb nearer."""

import msgspec
import numpy as np
from scipy.ndimage import minimum_filter1d, uniform_filter1d

from contract.geometry import Array, IntArray
from vehicle_agent.signals import Corridor

# A kerb belongs to the stations within this along the line, m; and farther aside to another road.
_ALONG_M, _ASIDE_M = 0.5, 8.0
# It takes so many cells within so many stations around one: a single one is a stone.
_STATIONS, _CELLS_MIN = 5, 3


def narrowed(corridor: Corridor, kerbs_map: Array, keep_m: float) -> Corridor:
    """The corridor with its edges at the kerbs (k, 2) that are seen inside it.

    keep_m  steps nearer to the line are none of its edges: the map has a lane there, and a speed bump or a
            lowered kerb across it is driven over
    """
    if not len(kerbs_map) or len(corridor.s_m) < _STATIONS:
        return corridor
    low, high = corridor.points_map.min(axis=0) - _ASIDE_M, corridor.points_map.max(axis=0) + _ASIDE_M
    near = kerbs_map[((low <= kerbs_map) & (kerbs_map <= high)).all(axis=1)]
    if not len(near):
        return corridor
    apart = near[:, None, :] - corridor.points_map[None, :, :]
    station: IntArray = np.argmin(apart[..., 0] ** 2 + apart[..., 1] ** 2, axis=1)
    dx, dy = apart[np.arange(len(near)), station].T
    cos, sin = np.cos(corridor.yaw_rad[station]), np.sin(corridor.yaw_rad[station])
    along, aside = cos * dx + sin * dy, cos * dy - sin * dx
    beside = np.abs(along) <= _ALONG_M
    left = _edge(station[beside & (aside > keep_m)], aside[beside & (aside > keep_m)], corridor.left_m)
    right = _edge(station[beside & (aside < -keep_m)], -aside[beside & (aside < -keep_m)], corridor.right_m)
    return msgspec.structs.replace(corridor, left_m=left, right_m=right)


def _edge(station: IntArray, aside_m: Array, edge_m: Array) -> Array:
    """(n,) the nearer of the map's edge and of the kerbs at or beside a station."""
    nearest = np.full(len(edge_m), np.inf)
    np.minimum.at(nearest, station, aside_m)
    inside = aside_m < edge_m[station]
    count = np.bincount(station[inside], minlength=len(edge_m)).astype(np.float64)
    enough = uniform_filter1d(count, _STATIONS, mode="constant") * _STATIONS >= _CELLS_MIN - 0.5
    kerb: Array = minimum_filter1d(nearest, _STATIONS, mode="nearest")
    return np.where(enough, np.minimum(edge_m, kerb), edge_m)
