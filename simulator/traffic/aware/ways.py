"""Everyone's own way: places at steps of own time, for the kernels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from contract.geometry import Array
from simulator.traffic.actors import Ints

# Own time between two places.
WAY_STEP_S = 0.05


@dataclass(frozen=True, slots=True)
class OwnWays:
    """Places of n people, one after the other.

    places (total, 2); first (n,) row of each person's first place; count (n,) places of each
    begins_s (n,) own time of the first place; ends_mps (n, 2) velocity after the last place
    """

    places: Array
    first: Ints
    count: Ints
    begins_s: Array
    ends_mps: Array


def own_ways(tracks: Sequence[tuple[Array, Array]]) -> OwnWays:
    """From (times_s (k,), states (k, 5)) of each person, as in `RecordedTrack`."""
    pieces, begins, ends = [], [], []
    for times, states in tracks:
        steps = max(1, int(np.ceil((times[-1] - times[0]) / WAY_STEP_S - 1e-9)))
        at = times[0] + WAY_STEP_S * np.arange(steps + 1)
        piece = np.column_stack([np.interp(at, times, states[:, k]) for k in (0, 1)])
        beyond_s = at[-1] - times[-1]
        piece[-1] += beyond_s * states[-1, 3:5]
        pieces.append(piece)
        begins.append(times[0])
        ends.append(states[-1, 3:5])
    count = np.array([len(piece) for piece in pieces], dtype=np.int64)
    first = np.concatenate((np.zeros(1, np.int64), np.cumsum(count)[:-1])) if len(count) else count
    return OwnWays(
        np.vstack(pieces) if pieces else np.zeros((0, 2)),
        first,
        count,
        np.array(begins, dtype=np.float64),
        np.array(ends, dtype=np.float64).reshape(-1, 2),
    )


@njit(cache=True)
def place_at(
    places: Array, first: int, count: int, begins_s: float, ends_mps: Array, own_s: float
) -> tuple[float, float]:
    """The place at a moment of own time; before the first and after the last at constant velocity."""
    k = (own_s - begins_s) / WAY_STEP_S
    if k >= count - 1:
        beyond_s = (k - (count - 1)) * WAY_STEP_S
        last = first + count - 1
        return places[last, 0] + beyond_s * ends_mps[0], places[last, 1] + beyond_s * ends_mps[1]
    if k <= 0.0:
        return places[first, 0], places[first, 1]
    i = int(k)
    share = k - i
    a, b = first + i, first + i + 1
    return (
        places[a, 0] + share * (places[b, 0] - places[a, 0]),
        places[a, 1] + share * (places[b, 1] - places[a, 1]),
    )


@njit(cache=True)
def places_at(
    places: Array, first: Ints, count: Ints, begins_s: Array, ends_mps: Array, own_s: Array
) -> Array:
    """(n, 2) the place of each person at their own time, (n,)."""
    out = np.empty((len(first), 2))
    for i in range(len(first)):
        out[i, 0], out[i, 1] = place_at(places, first[i], count[i], begins_s[i], ends_mps[i], own_s[i])
    return out
