"""A peer: each track takes the nearest object, one after the other."""

import numpy as np

from contract.geometry import Array, IntArray

_REACH_M = 1.0
_MISSES_MAX = 3
_GAIN, _VELOCITY_GAIN = 0.6, 0.3


class NearestNeighbourTracker:
    """Constant velocity with fixed gains, and the nearest object within a metre."""

    def __init__(self) -> None:
        self._next = 1
        self._ids: IntArray = np.empty(0, np.int64)
        self._places: Array = np.empty((0, 2))
        self._velocities: Array = np.empty((0, 2))
        self._misses: IntArray = np.empty(0, np.int64)

    def step(self, places: Array, dt_s: float) -> tuple[IntArray, Array]:
        """(ids (m,), places (m, 2)) of the tracks after a frame with objects at places (n, 2)."""
        self._places = self._places + dt_s * self._velocities
        apart = np.hypot(
            self._places[:, None, 0] - places[None, :, 0], self._places[:, None, 1] - places[None, :, 1]
        )
        is_new = np.ones(len(places), np.bool_)
        self._misses = self._misses + 1
        for flat in np.argsort(apart, axis=None, kind="stable"):
            t, d = np.unravel_index(flat, apart.shape)
            if apart[t, d] > _REACH_M:
                break
            if self._misses[t] == 0 or not is_new[d]:
                continue
            off = places[d] - self._places[t]
            self._places[t] += _GAIN * off
            self._velocities[t] += _VELOCITY_GAIN * off / max(dt_s, 1e-3)
            self._misses[t], is_new[d] = 0, False
        alive = self._misses <= _MISSES_MAX
        new = places[is_new]
        self._ids = np.concatenate((self._ids[alive], self._next + np.arange(len(new))))
        self._next += len(new)
        self._places = np.vstack((self._places[alive], new))
        self._velocities = np.vstack((self._velocities[alive], np.zeros((len(new), 2))))
        self._misses = np.concatenate((self._misses[alive], np.zeros(len(new), np.int64)))
        return self._ids.copy(), self._places.copy()
