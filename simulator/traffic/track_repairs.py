"""Repairs of recorded tracks: rows that jump away and back are dropped, broken tracks are cut in two."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array

# A shorter gap is bridged by interpolation. A longer one ends the track: nothing is made up.
GAP_S_MAX = 1.0
# A piece that is shorter, and that jumps away and back, is an error of the tracker.
SPIKE_S_MAX = 0.25
_SLACK_M = 0.5
_GAP_S_MIN = 1e-6


@dataclass(frozen=True, slots=True)
class Repairs:
    """What was done to a recording: gaps bridged, tracks cut in two, rows dropped."""

    bridged_gaps: int = 0
    cuts: int = 0
    dropped_rows: int = 0

    def __add__(self, other: "Repairs") -> "Repairs":
        return Repairs(
            self.bridged_gaps + other.bridged_gaps,
            self.cuts + other.cuts,
            self.dropped_rows + other.dropped_rows,
        )


def repaired(table: Array, frame_s: float, speed_mps_max: float) -> tuple[list[Array], Repairs]:
    """The track without jumps, cut where it cannot be one body's motion; and what was done.

    table          (n, k) time, x, y, ...; times rise
    frame_s        the time between frames; a longer step is a gap
    speed_mps_max  the fastest that such a body moves
    Returns        tables of the pieces in order of time, never empty
    """
    times, steps_s = table[:, 0], np.diff(table[:, 0])
    jumps_m = np.hypot(*np.diff(table[:, 1:3], axis=0).T)
    breaks = (steps_s > GAP_S_MAX + _GAP_S_MIN) | (jumps_m > _SLACK_M + speed_mps_max * steps_s)
    pieces = np.split(np.arange(len(times)), np.flatnonzero(breaks) + 1)
    kept = [pieces[0]]
    dropped = 0
    for piece in pieces[1:]:
        if _joins(table, kept[-1][-1], piece[0], speed_mps_max):
            kept[-1] = np.concatenate((kept[-1], piece))
        elif _is_spike(times, piece):
            dropped += len(piece)
        elif _is_spike(times, kept[-1]):
            dropped += len(kept[-1])
            kept[-1] = piece
        else:
            kept.append(piece)
    bridged = sum(int((np.diff(times[piece]) > 1.5 * frame_s).sum()) for piece in kept)
    return [table[piece] for piece in kept], Repairs(bridged, len(kept) - 1, dropped)


def _joins(table: Array, last: int, first: int, speed_mps_max: float) -> bool:
    gap_s = table[first, 0] - table[last, 0]
    jump_m = np.hypot(*(table[first, 1:3] - table[last, 1:3]))
    return bool(gap_s <= GAP_S_MAX + _GAP_S_MIN and jump_m <= _SLACK_M + speed_mps_max * gap_s)


def _is_spike(times: Array, piece: NDArray[np.int64]) -> bool:
    return bool(times[piece[-1]] - times[piece[0]] < SPIKE_S_MAX)


def velocities_mps(times_s: Array, places: Array, window_s: float) -> Array:
    """(n, 2) slopes of straight lines fitted to the places within half a window of each time.

    A single place has velocity 0.
    """
    low = np.searchsorted(times_s, times_s - 0.5 * window_s - 1e-9)
    high = np.searchsorted(times_s, times_s + 0.5 * window_s + 1e-9)
    t = times_s - times_s[0]
    columns = np.column_stack((t, t * t, places, t[:, None] * places))
    sums = np.vstack((np.zeros(columns.shape[1]), np.cumsum(columns, axis=0)))
    totals = sums[high] - sums[low]
    n = (high - low).astype(np.float64)
    spread = n * totals[:, 1] - totals[:, 0] ** 2
    moving = spread > 1e-12
    slopes: Array = np.zeros((len(times_s), 2))
    for k in (0, 1):
        numerator = n * totals[:, 4 + k] - totals[:, 0] * totals[:, 2 + k]
        slopes[moving, k] = numerator[moving] / spread[moving]
    return slopes
