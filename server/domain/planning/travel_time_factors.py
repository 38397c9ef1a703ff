"""How much longer driving takes at each hour of the day than planned, learnt from what was driven."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from statistics import median

HOURS = 24
FACTOR_MIN, FACTOR_MAX = 0.5, 3.0
# With so many legs in an hour the measured and the planned time count alike.
_LEGS_OF_PLAN = 20
# A leg that took less than a tenth or more than ten times of its time is invalid: its events came late.
_RATIO_MIN, _RATIO_MAX = 0.1, 10.0


@dataclass(frozen=True, slots=True)
class DrivenLeg:
    """A drive from stop to stop without a halt at any place between; hour: local, in which it was driven."""

    campus_id: str
    vehicle_id: str
    left_at: datetime
    from_stop: str
    to_stop: str
    hour: int
    planned_s: float
    driven_s: float


@dataclass(frozen=True, slots=True)
class TravelTimeFactors:
    """For each local hour the factor on planned times, and how many legs it rests on."""

    factors: tuple[float, ...]
    legs: tuple[int, ...]
    learned_at: datetime | None = None

    def at(self, hour: float) -> float:
        return travel_time_factor_at(self.factors, hour)


AS_PLANNED = TravelTimeFactors((1.0,) * HOURS, (0,) * HOURS)


def travel_time_factor_at(factors: Sequence[float], hour: float) -> float:
    """The factor at a time of day in hours: that of an hour at its middle, going over from one to the next.

    So no expected time jumps at the stroke of the hour.
    """
    before = int((hour - 0.5) // 1.0)
    share = hour - 0.5 - before
    return (1.0 - share) * factors[before % HOURS] + share * factors[(before + 1) % HOURS]


def learned_from(legs: Sequence[DrivenLeg], at: datetime) -> TravelTimeFactors:
    """The median of driven over planned times, nearer to 1 if there are few legs, within [0.5, 3]."""
    ratios: list[list[float]] = [[] for _ in range(HOURS)]
    for leg in legs:
        ratio = leg.driven_s / leg.planned_s
        if _RATIO_MIN <= ratio <= _RATIO_MAX:
            ratios[leg.hour].append(ratio)
    return TravelTimeFactors(
        tuple(_factor(found) for found in ratios), tuple(len(found) for found in ratios), at
    )


def _factor(ratios: Sequence[float]) -> float:
    if not ratios:
        return 1.0
    count = len(ratios)
    drawn = (count * median(ratios) + _LEGS_OF_PLAN) / (count + _LEGS_OF_PLAN)
    return min(max(drawn, FACTOR_MIN), FACTOR_MAX)
