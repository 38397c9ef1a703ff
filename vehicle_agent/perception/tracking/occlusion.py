"""Which tracks something nearer hides from the lidars."""

import numpy as np

from contract.geometry import Array, BoolArray

# What hides a place is nearer than it by this.
_NEARER_M = 0.4


def hidden_places(places_base: Array, poses_base: Array, sizes_m: Array, viewpoint_x_m: float) -> BoolArray:
    """(n,) True where an object stands between the lidars and a place.

    places_base (n, 2); poses_base (k, 3), sizes_m (k, 3) of the scan's objects; viewpoint_x_m of the lidars
    """
    if not len(places_base) or not len(poses_base):
        return np.zeros(len(places_base), np.bool_)
    x, y = places_base[:, 0] - viewpoint_x_m, places_base[:, 1]
    ox, oy = poses_base[:, 0] - viewpoint_x_m, poses_base[:, 1]
    ranges, nearer = np.hypot(x, y), np.maximum(np.hypot(ox, oy), 0.3)
    bearing = np.arctan2(oy, ox)
    # The half width of an object as it is seen from here.
    off = poses_base[:, 2] - bearing
    half = 0.5 * (np.abs(sizes_m[:, 0] * np.sin(off)) + np.abs(sizes_m[:, 1] * np.cos(off)))
    apart = np.arctan2(y, x)[:, None] - bearing[None, :]
    apart = np.abs((apart + np.pi) % (2.0 * np.pi) - np.pi)
    hides = (apart < np.arctan2(half, nearer)[None, :]) & (nearer[None, :] < ranges[:, None] - _NEARER_M)
    hidden: BoolArray = np.asarray(hides.any(axis=1))
    return hidden
