"""A simulated day in the numbers by which fleets are compared."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from campusloop.studies.dispatch.fleet_day import FleetDay, RideOutcome

# Sums of many doubles.
_ROUNDING_S = 1e-3


@dataclass(frozen=True, slots=True)
class DayFigures:
    """Counts of rides; times of those that were served, None where none was.

    refused_by    rule -> rides
    in_vain       cancelled when a shuttle had set out for them
    wait          from the wished time to the beginning of boarding
    ride_over_direct  mean of time on board over the drive without anybody else
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
    fates = list(day.fates.values())
    served = [fate for fate in fates if fate.arrival_s is not None]
    waits = [_at(fate.pickup_s) - fate.earliest_s for fate in served]
    on_board = [_at(fate.arrival_s) - _at(fate.pickup_s) - fate.dwell_s for fate in served]
    ratios = [s / fate.direct_s for s, fate in zip(on_board, served, strict=True) if fate.direct_s > 0.0]
    rules = Counter(fate.rule for fate in fates if fate.rule)
    return DayFigures(
        asked=len(fates),
        served=len(served),
        cancelled=sum(fate.cancelled for fate in fates),
        in_vain=day.in_vain,
        refused=rules.total(),
        refused_by=dict(sorted(rules.items())),
        wait_median_s=_rounded(waits, 50.0),
        wait_p95_s=_rounded(waits, 95.0),
        ride_mean_s=round(float(np.mean(on_board)), 1) if served else None,
        ride_over_direct=round(float(np.mean(ratios)), 3) if ratios else None,
        driving_h=round(day.driven_s / 3600.0, 2),
        promises_kept=sum(_is_kept(fate) for fate in served),
    )


def _is_kept(fate: RideOutcome) -> bool:
    if fate.promise is None:
        return False
    from_s, to_s, by_s = fate.promise
    in_window = from_s - _ROUNDING_S <= _at(fate.pickup_s) <= to_s + _ROUNDING_S
    return in_window and _at(fate.arrival_s) <= by_s + _ROUNDING_S


def _at(moment_s: float | None) -> float:
    assert moment_s is not None, "only of rides that were served"
    return moment_s


def _rounded(values: Sequence[float], percentile: float) -> float | None:
    return round(float(np.percentile(values, percentile)), 1) if values else None
