"""The range of times in which a planned pickup or arrival really happens, told instead of one minute.

A table that can be read aloud. It was tuned on simulated days; `benchmarks/eta` measures on others how many
pickups and arrivals fall inside.
"""

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Literal

from server.domain.instants import EPOCH

# Plans allow for people in the way and for other shuttles. On a free road a shuttle needs this much less of
# the time that is left, but it is not so early far ahead of the pickup, where its plan has other stops too.
_EARLY_S, _EARLY_RATIO, _EARLY_S_MAX = 20.0, 0.3, 300.0

# How much later than planned it may come, by how far ahead the pickup is: to 1, 2, 4, 8, 15 minutes, later.
_HORIZONS_S = (60.0, 120.0, 240.0, 480.0, 900.0)
_LATE_S: Mapping[str, tuple[float, ...]] = {
    # The shuttle is planned to be there before the promised window opens: it has time in hand.
    "early": (60.0, 30.0, 15.0, 15.0, 15.0, 15.0),
    "on_time": (45.0, 20.0, 30.0, 30.0, 30.0, 30.0),
    # Later than it was promised at first: what has held it up may last.
    "behind": (120.0, 120.0, 90.0, 120.0, 150.0, 150.0),
}
# A pickup planned within this time after its window opens is where the promise put it.
_ON_TIME_S = 62.0
# For each stop before the pickup, where people get on and off and from where the plan may still change.
_PER_STOP_S, _STOPS_MAX = 30.0, 3
# Of the time that is left to an arrival, a shuttle on a free road needs this much; less if it has other stops
# before, because a stop at which no rider waits or gets off is left out.
_DRIVEN_RATIO_MIN, _DRIVEN_RATIO_MIN_WITH_STOPS = 0.58, 0.4
# How much later than planned the party may arrive, beside _ARRIVAL_PER_STOP_S for each stop before.
_ARRIVAL_LATE_S, _ARRIVAL_PER_STOP_S = 15.0, 20.0
# Before the party has boarded. A shuttle comes early, drives fast and leaves out stops: of the time to the
# pickup and of the ride it may need so little, less these seconds. At most it needs the wait as planned and
# this part of the ride, and some seconds for what holds it up.
_WAIT_RATIO_MIN, _RIDE_RATIO_MIN, _RIDE_RATIO_MIN_WITH_STOPS, _RIDE_EARLY_S = 0.5, 0.45, 0.35, 120.0
_RIDE_RATIO_MAX, _RIDE_LATE_S = 0.8, 120.0
# Both ends are rounded outwards, so that they do not move with every second.
_STEP_S = 30.0

Standing = Literal["early", "on_time", "behind"]


@dataclass(frozen=True, slots=True)
class PlannedPickup:
    """eta  when the party is picked up as planned now: not before the window opens
    opens  when the promised window opens, until when the shuttle waits for the party
    stops_before  stops that the shuttle makes before this one
    """

    eta: datetime
    opens: datetime
    stops_before: int


@dataclass(frozen=True, slots=True)
class ExpectedRange:
    """The party is picked up, or arrives, between these in 9 of 10 cases."""

    earliest: datetime
    latest: datetime


def pickup_range(now: datetime, pickup: PlannedPickup) -> ExpectedRange:
    """The range of a pickup as planned now; earliest <= latest, neither in the past."""
    eta = max(pickup.eta, now)
    ahead_s = (eta - now).total_seconds()
    early_s = min(_EARLY_S + _EARLY_RATIO * ahead_s, _EARLY_S_MAX)
    earliest = max(now, pickup.opens, eta - timedelta(seconds=early_s))
    late_s = _LATE_S[standing_of(pickup)][bisect_right(_HORIZONS_S, ahead_s)]
    late_s += _PER_STOP_S * min(pickup.stops_before, _STOPS_MAX)
    latest = max(earliest, eta + timedelta(seconds=late_s))
    return ExpectedRange(max(now, _rounded(earliest, up=False)), _rounded(latest, up=True))


@dataclass(frozen=True, slots=True)
class PlannedArrival:
    """Of a party that is aboard.

    eta  when it arrives as planned now
    stops_before  stops that the shuttle makes before
    """

    eta: datetime
    stops_before: int


def arrival_range(now: datetime, arrival: PlannedArrival) -> ExpectedRange:
    """The range of an arrival as planned now; earliest <= latest, neither in the past."""
    eta = max(arrival.eta, now)
    ratio = _DRIVEN_RATIO_MIN_WITH_STOPS if arrival.stops_before else _DRIVEN_RATIO_MIN
    late_s = _ARRIVAL_LATE_S + _ARRIVAL_PER_STOP_S * min(arrival.stops_before, _STOPS_MAX)
    earliest = max(now, _rounded(now + ratio * (eta - now), up=False))
    return ExpectedRange(earliest, _rounded(eta + timedelta(seconds=late_s), up=True))


@dataclass(frozen=True, slots=True)
class PlannedRide:
    """Of a party that waits.

    eta  when it arrives as planned now; pickup: when it is picked up, which is before that
    stops_between  stops that the shuttle makes on the ride, while the party is aboard
    """

    pickup: PlannedPickup
    eta: datetime
    stops_between: int


def waiting_arrival_range(now: datetime, ride: PlannedRide) -> ExpectedRange:
    """The range of an arrival before the party has boarded; earliest <= latest, neither in the past."""
    boards = max(ride.pickup.eta, now)
    wait, drive = boards - now, max(ride.eta - boards, timedelta(0))
    ratio = _RIDE_RATIO_MIN_WITH_STOPS if ride.stops_between else _RIDE_RATIO_MIN
    earliest = now + _WAIT_RATIO_MIN * wait + ratio * drive - timedelta(seconds=_RIDE_EARLY_S)
    earliest = max(now, _rounded(earliest, up=False))
    latest = boards + _RIDE_RATIO_MAX * drive + timedelta(seconds=_RIDE_LATE_S)
    return ExpectedRange(earliest, max(earliest, _rounded(latest, up=True)))


def standing_of(pickup: PlannedPickup) -> Standing:
    """How the plan stands to the promised window."""
    after_s = (pickup.eta - pickup.opens).total_seconds()
    if after_s <= 0.0:
        return "early"
    return "on_time" if after_s <= _ON_TIME_S else "behind"


def _rounded(moment: datetime, *, up: bool) -> datetime:
    step = timedelta(seconds=_STEP_S)
    steps, rest = divmod(moment - EPOCH, step)
    return EPOCH + (steps + (1 if up and rest else 0)) * step
