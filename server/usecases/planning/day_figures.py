"""The figures of a simulated day, by which fleets are compared."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from server.usecases.planning.fleet_day import FleetDay, RideOutcome

# Sums of many doubles.
_ROUNDING_S = 1e-3


@dataclass(frozen=True, slots=True)
class DayFigures:
    """Counts of rides, and times of the served ones, None without any.

    refused_by    rule -> rides
    in_vain       cancelled when a shuttle was already driving to the pickup
    wait          from the requested time to the beginning of boarding
    ride_over_direct  mean ratio of the time on board to the direct drive
    """

    asked: int
    served: int
    cancelled: int
    in_vain: int
    refused: int
    refused_by: dict[str, int]
    wait_median_s: float | None
    wait_p95_s: float | None
    ride_mean_s: float | None
    ride_over_direct: float | None
    driving_h: float
    promises_kept: int


def figures_of(day: FleetDay) -> DayFigures:
    outcomes = list(day.outcomes.values())
    served = [outcome for outcome in outcomes if outcome.arrival_s is not None]
    waits = [_at(outcome.pickup_s) - outcome.earliest_s for outcome in served]
    on_board = [_at(outcome.arrival_s) - _at(outcome.pickup_s) - outcome.dwell_s for outcome in served]
    ratios = [
        s / outcome.direct_s for s, outcome in zip(on_board, served, strict=True) if outcome.direct_s > 0.0
    ]
    rules = Counter(outcome.rule for outcome in outcomes if outcome.rule)
    return DayFigures(
        asked=len(outcomes),
        served=len(served),
        cancelled=sum(outcome.cancelled for outcome in outcomes),
        in_vain=day.in_vain,
        refused=rules.total(),
        refused_by=dict(sorted(rules.items())),
        wait_median_s=_rounded(waits, 50.0),
        wait_p95_s=_rounded(waits, 95.0),
        ride_mean_s=round(float(np.mean(on_board)), 1) if served else None,
        ride_over_direct=round(float(np.mean(ratios)), 3) if ratios else None,
        driving_h=round(day.driven_s / 3600.0, 2),
        promises_kept=sum(_is_promise_kept(outcome) for outcome in served),
    )


def _is_promise_kept(outcome: RideOutcome) -> bool:
    if outcome.promise is None:
        return False
    from_s, to_s, by_s = outcome.promise
    in_window = from_s - _ROUNDING_S <= _at(outcome.pickup_s) <= to_s + _ROUNDING_S
    return in_window and _at(outcome.arrival_s) <= by_s + _ROUNDING_S


def _at(moment_s: float | None) -> float:
    assert moment_s is not None, "only of rides that were served"
    return moment_s


def _rounded(values: Sequence[float], percentile: float) -> float | None:
    return round(float(np.percentile(values, percentile)), 1) if values else None
