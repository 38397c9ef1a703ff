"""One day of rides drawn from a profile: the same seed gives the same day."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from zoneinfo import ZoneInfo

import numpy as np

from simulator.demand.profile import DemandProfile

_HOUR_S = 3600.0
# The aggregates lack the times of cancellation. The mean wait is 2.5 min, so most cancellations are assumed
# to come within a few minutes.
_CANCELLED_AFTER_MEAN_S = 150.0
# The aggregates also lack party sizes and wheelchairs; these are assumptions.
_PARTY_RATIO = (0.80, 0.14, 0.04, 0.02)
_WHEELCHAIR_RATIO = 0.01


@dataclass(frozen=True, slots=True)
class WantedRide:
    """A ride that a passenger requests, in local time.

    announced_at  when it is booked; earliest: the earliest pickup
    cancelled_at  when it is cancelled, unless it is picked up before; None for never
    """

    ride: str
    announced_at: datetime
    earliest: datetime
    from_stop: str
    to_stop: str
    party: int = 1
    wheelchairs: int = 0
    booked_by: str = ""
    cancelled_at: datetime | None = None


def draw_day(
    profile: DemandProfile, stops: Sequence[str], day: date, zone: ZoneInfo, rides: int, seed: int
) -> tuple[WantedRide, ...]:
    """The rides of a local day, in the order of booking.

    stops   of the campus, in the order of demand, the highest first; at least two

    A Poisson process whose rate is constant within each hour of a weekday, given the number of its events:
    each falls into an hour with the hour's share, uniformly within it (Lewis and Shedler 1979). Rides are
    booked for immediate pickup.
    """
    rng = np.random.default_rng(seed)
    hours = rng.choice(24, rides, p=profile.hour_ratio(day.weekday()))
    seconds = np.floor((hours + rng.random(rides)) * _HOUR_S)
    # Sorted first, so that the other draws belong to the same ride for every map.
    seconds.sort()
    pairs = rng.choice(len(stops) ** 2, rides, p=profile.pair_ratio(len(stops)).ravel())
    methods = rng.choice(len(profile.methods), rides, p=profile.method_ratio)
    cancel_draws = rng.random(rides)
    after_s = np.ceil(rng.exponential(_CANCELLED_AFTER_MEAN_S, rides))
    parties = 1 + rng.choice(len(_PARTY_RATIO), rides, p=_PARTY_RATIO)
    chairs = rng.random(rides) < _WHEELCHAIR_RATIO
    midnight = datetime(day.year, day.month, day.day, tzinfo=zone)
    wanted = []
    for k in range(rides):
        method = profile.methods[int(methods[k])]
        at = midnight + timedelta(seconds=float(seconds[k]))
        cancelled_at = (
            at + timedelta(seconds=float(after_s[k])) if cancel_draws[k] < method.cancel_ratio else None
        )
        origin, destination = divmod(int(pairs[k]), len(stops))
        wanted.append(
            WantedRide(
                ride=f"r{k + 1}",
                announced_at=at,
                earliest=at,
                from_stop=stops[origin],
                to_stop=stops[destination],
                party=int(parties[k]),
                wheelchairs=int(chairs[k]),
                booked_by=method.name,
                cancelled_at=cancelled_at,
            )
        )
    return tuple(wanted)
