"""Replays recorded people and cars. They do not react to shuttles."""

import numpy as np

from contract.geometry import Array
from simulator.traffic.actors import Bodies, no_bodies
from simulator.traffic.crowd import V_X, V_Y
from simulator.traffic.recordings import Clip, RecordedTrack

# People present at the end of the recording continue at constant velocity for this time.
AFTERWARDS_S = 60.0
# Times are sums of floats.
_AT_ONCE_S = 1e-6


class ReplayedTraffic:
    """Plays a clip from `from_s` on, without some tracks; `hold` stops its clock and hides all bodies.

    appear_m  tracks that begin nearer than this to a vehicle are left out: when a recording is moved to
              another place, a track may begin in front of a bumper
    removed   number -> (time_s, x, y) of each track that was left out so
    delayed   none: recorded people are on time
    """

    def __init__(
        self, clip: Clip, from_s: float, without: frozenset[int] = frozenset(), appear_m: float = 0.0
    ) -> None:
        self.clock_s = from_s
        self._appear_m = appear_m
        self.removed: dict[int, tuple[float, float, float]] = {}
        self.delayed: set[int] = set()
        self.hold = False
        self._ends_s = clip.ends_s
        self._tracks = tuple(track for track in clip.tracks if track.number not in without)
        self._begins_s = np.array([track.times_s[0] - _AT_ONCE_S for track in self._tracks])

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """Advance the clock; present tracks do not react to the vehicles."""
        if self.hold:
            return
        before_s = self.clock_s
        self.clock_s += dt_s
        if self._appear_m <= 0.0 or not len(vehicles):
            return
        for i in np.flatnonzero((before_s < self._begins_s) & (self._begins_s <= self.clock_s)):
            track = self._tracks[i]
            apart_m = vehicles[:, [V_X, V_Y]] - track.states[0, :2]
            if np.hypot(apart_m[:, 0], apart_m[:, 1]).min() < self._appear_m:
                x, y = track.states[0, :2]
                self.removed[track.number] = (float(track.times_s[0]), float(x), float(y))

    def bodies(self) -> Bodies:
        """All bodies that are present now."""
        if self.hold:
            return no_bodies()
        there = [(track, state) for track in self._tracks if (state := self._state(track)) is not None]
        if not there:
            return no_bodies()
        states = np.array([state for _, state in there])
        return Bodies(
            np.array([track.number for track, _ in there], dtype=np.int64),
            np.array([track.kind for track, _ in there], dtype=np.int64),
            np.ascontiguousarray(states[:, :3]),
            np.ascontiguousarray(states[:, 3:]),
            np.array([track.size_m for track, _ in there]),
        )

    def _state(self, track: RecordedTrack) -> Array | None:
        """x, y, yaw, vx, vy now, interpolated between observations; None if the track is not present."""
        t, times = self.clock_s, track.times_s
        if t < times[0] - _AT_ONCE_S or track.number in self.removed:
            return None
        if t > times[-1]:
            beyond_s = t - float(times[-1])
            if times[-1] < self._ends_s - 0.1 or beyond_s > AFTERWARDS_S:
                return None
            gone: Array = track.states[-1].copy()
            gone[:2] += beyond_s * gone[3:]
            return gone
        i = min(int(np.searchsorted(times, t, side="right")), len(times) - 1)
        if i == 0:
            first: Array = track.states[0]
            return first
        share = (t - times[i - 1]) / (times[i] - times[i - 1])
        between: Array = track.states[i - 1] + share * (track.states[i] - track.states[i - 1])
        return between
