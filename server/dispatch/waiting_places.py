"""Where idle vehicles wait: at the places from which expected riders are reached soonest.

The places are chosen for all idle vehicles together (a k-median problem). One vehicle moves at a time, and
only if the gain is worth the drive, so that the moves end.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np

from contract.geometry import Array

# No pickup is promised so late. A stop that cannot be reached counts the same for every place.
_FAR_S = 7200.0
_EXACT_UP_TO = 2000


@dataclass(frozen=True, slots=True)
class VehicleMove:
    """vehicle: which of the idle ones; place: row of the ways; gain_s: of the expected mean wait."""

    vehicle: int
    place: int
    gain_s: float


def mean_wait_s(places: Sequence[int], ways_s: Array, rates: Array) -> float:
    """Expected drive to the next rider with a vehicle at each of these places; 0 without expected riders.

    ways_s (places, stops) planned seconds; rates (stops,) of pickups
    """
    total = float(rates.sum())
    if total <= 0.0:
        return 0.0
    if not places:
        return _FAR_S
    nearest = np.minimum(ways_s[list(places)], _FAR_S).min(axis=0)
    return float(nearest @ rates) / total


def best_move(
    at: Sequence[int], free: Sequence[int], ways_s: Array, rates: Array, gain_s_min: float
) -> VehicleMove | None:
    """The first move towards the best places for all vehicles; None if none gains gain_s_min.

    at    where each idle vehicle waits, no two at one place; free: places that one may move to
    """
    if not at or not free:
        return None
    now_s = mean_wait_s(at, ways_s, rates)
    aim = _best_places(at, free, ways_s, rates)
    best: VehicleMove | None = None
    for vehicle, place in enumerate(at):
        if place in aim:
            continue
        others = [other for other in at if other != place]
        for target in sorted(aim - set(at)):
            gain_s = now_s - mean_wait_s([*others, target], ways_s, rates)
            if gain_s >= gain_s_min and (best is None or gain_s > best.gain_s):
                best = VehicleMove(vehicle, target, gain_s)
    return best


def _best_places(at: Sequence[int], free: Sequence[int], ways_s: Array, rates: Array) -> set[int]:
    """One for each vehicle: the best choice of all if there are few, else a local optimum."""
    places = sorted({*at, *free})
    if comb(len(places), len(at)) <= _EXACT_UP_TO:
        choices = combinations(places, len(at))
        _, best = min((mean_wait_s(choice, ways_s, rates), choice) for choice in choices)
        return set(best)
    chosen, wait_s = list(at), mean_wait_s(at, ways_s, rates)
    is_better = True
    while is_better:
        is_better = False
        for k in range(len(chosen)):
            for place in places:
                tried = [*chosen[:k], place, *chosen[k + 1 :]]
                tried_s = mean_wait_s(tried, ways_s, rates)
                if place not in chosen and tried_s < wait_s - 1e-9:
                    chosen, wait_s, is_better = tried, tried_s, True
    return set(chosen)
