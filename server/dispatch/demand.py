"""Where riders are expected: rates of pickups learned from those of the past weeks."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import date, timedelta

import numpy as np

from contract.geometry import Array

WORKDAY, FREE_DAY = 0, 1
HOURS = 24
# A rider of 8:55 might have come at 9:05 as well.
_BLUR = (0.25, 0.5, 0.25)


@dataclass(frozen=True, slots=True)
class Pickup:
    """A requested pickup at this stop, refused ones included; local day and hour."""

    stop: int
    day: date
    hour: int


@dataclass(frozen=True, slots=True)
class DemandWeights:
    """How past days are weighted.

    half_life_days  a day counts half as much as one so many days later
    prior_days      so many days without a single pickup are added to what has been seen: with little data
                    little is expected
    """

    half_life_days: float = 14.0
    prior_days: float = 2.0


def learned_rates(
    pickups: Iterable[Pickup], today: date, kind_of: Callable[[date], int], stops: int, weights: DemandWeights
) -> Array:
    """(2, 24, stops) pickups an hour expected on a day of either kind, in each hour, at each stop.

    pickups  of whole days before `today`; the first of them begins what has been seen
    kind_of  WORKDAY or FREE_DAY
    """
    counts = np.zeros((2, HOURS, stops))
    first = today
    for pickup in pickups:
        if pickup.day >= today:
            continue
        first = min(first, pickup.day)
        counts[kind_of(pickup.day), pickup.hour, pickup.stop] += _weight(pickup.day, today, weights)
    seen = np.full(2, weights.prior_days)
    for offset in range((today - first).days):
        day = first + timedelta(days=offset)
        seen[kind_of(day)] += _weight(day, today, weights)
    rates = counts / seen[:, None, None]
    blurred: Array = sum(
        share * np.roll(rates, shift, axis=1) for share, shift in zip(_BLUR, (-1, 0, 1), strict=True)
    )
    return blurred


def _weight(day: date, today: date, weights: DemandWeights) -> float:
    return float(0.5 ** ((today - day).days / weights.half_life_days))
