"""How recorded people deviate from where they would be at constant velocity."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, BoolArray
from simulator.traffic.recordings import Clip, RecordedTrack

HORIZONS_S = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
_EVERY_S = 0.1
_STILL_MPS = 0.2


@dataclass(frozen=True, slots=True)
class Deviations:
    """n observations at HORIZONS_S; nan beyond the end of a track.

    speed_mps  (n,) now
    along_m, across_m  (n, h) ahead of, and to the left of, the place that constant velocity leads to
    """

    speed_mps: Array
    along_m: Array
    across_m: Array

    def where(self, chosen: BoolArray) -> "Deviations":
        return Deviations(self.speed_mps[chosen], self.along_m[chosen], self.across_m[chosen])


def deviations(clips: Sequence[Clip]) -> Deviations:
    """Of all people on foot, each 0.1 s."""
    found = [_of_person(track) for clip in clips for track in clip.tracks if not track.is_driven]
    return Deviations(
        np.concatenate([one.speed_mps for one in found]),
        np.concatenate([one.along_m for one in found]),
        np.concatenate([one.across_m for one in found]),
    )


def _of_person(track: RecordedTrack) -> Deviations:
    begins_s, ends_s = float(track.times_s[0]), float(track.times_s[-1])
    now_s: Array = np.arange(begins_s, ends_s, _EVERY_S)
    later_s = now_s[:, None] + np.array(HORIZONS_S)[None]
    x, y, vx, vy = (_at(track, column, now_s) for column in (0, 1, 3, 4))
    off_x = _at(track, 0, later_s) - x[:, None] - vx[:, None] * np.array(HORIZONS_S)
    off_y = _at(track, 1, later_s) - y[:, None] - vy[:, None] * np.array(HORIZONS_S)
    gone = later_s > ends_s
    off_x[gone], off_y[gone] = np.nan, np.nan
    speed = np.hypot(vx, vy)
    walks = speed > _STILL_MPS
    ux = np.where(walks, vx / np.maximum(speed, _STILL_MPS), 1.0)[:, None]
    uy = np.where(walks, vy / np.maximum(speed, _STILL_MPS), 0.0)[:, None]
    return Deviations(speed, ux * off_x + uy * off_y, ux * off_y - uy * off_x)


def _at(track: RecordedTrack, column: int, times_s: Array) -> Array:
    found: Array = np.interp(times_s, track.times_s, track.states[:, column])
    return found
