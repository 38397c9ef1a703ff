"""The fit of the people's reaction to recordings: random search, and the mean of the best tenth.

What can be measured is not searched. The margin is what 19 of 20 of the people in a car's way kept; notice
and deceleration are the medians of those who slowed down before the car was there.

The loss of a set of parameters is the mean over people in a car's way of their mean displacement from the
recording, on desired ways. Free speeds are not known: the best of three percentiles of a person's own speeds
counts, for every set alike. The landscape is flat and rough around its minimum, so the minimum itself would
fit the noise of single walks.
"""

from collections.abc import Callable, Sequence

import msgspec
import numpy as np

from benchmarks.people.distributions import joined, recorded_encounters
from benchmarks.people.samples import Drive, outline
from contract.geometry import Array
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.reproduction import MetPeople, Walk, met_people, walk
from simulator.traffic.aware.ways import own_ways

FREE_PERCENTILES = (55.0, 70.0, 85.0)
# Where each parameter is searched.
RANGES = {"sidestep_mps": (0.2, 1.2), "sidestep_cost": (0.2, 2.0)}
_MARGIN_QUANTILE = 0.05
_DISPLACEMENT_M_MAX = 2.0
_BEST_SHARE = 0.1


def fitted(drives: Sequence[Drive], tries: int, seed: int, tell: Callable[[str], None]) -> ReactionParams:
    """The mean of the best tenth of `tries` random sets of parameters."""
    begin, met = measured(drives), people_met(drives)
    rng = np.random.default_rng([seed, *b"people"])
    low, high = np.array(list(RANGES.values())).T
    sets = rng.uniform(low, high, (tries, len(RANGES)))
    losses = np.empty(tries)
    for k, row in enumerate(sets):
        losses[k] = loss_m(met, _params(begin, row))
        tell(f"{k + 1} of {tries}: {losses[k]:.4f} m, least {losses[: k + 1].min():.4f} m")
    best = np.argsort(losses, kind="stable")[: max(1, round(_BEST_SHARE * tries))]
    return _params(begin, sets[best].mean(axis=0))


def people_met(drives: Sequence[Drive]) -> list[list[MetPeople]]:
    """For each drive that met someone, its people at each of FREE_PERCENTILES."""
    found = [[met_people(drive.clip, drive.car, p) for p in FREE_PERCENTILES] for drive in drives]
    return [each for each in found if each[0].people]


def _params(measured: ReactionParams, row: Array) -> ReactionParams:
    searched = {name: float(value) for name, value in zip(RANGES, row, strict=True)}
    return msgspec.structs.replace(measured, **searched)


def measured(drives: Sequence[Drive]) -> ReactionParams:
    """Margin, notice and deceleration of the recorded people in a car's way; the others as they are."""
    found = []
    for drive in drives:
        people = [track for track in drive.clip.tracks if not track.is_driven]
        ways = own_ways([(person.times_s, person.states) for person in people])
        params = ReactionParams()
        limits = params.limits(len(people))
        alone = walk(people, ways, limits, params, drive.car, drive.clip.ends_s, None)
        found.append(recorded_encounters(people, alone))
    encounters = joined(found)
    return ReactionParams(
        margin_m=float(np.quantile(encounters.gaps_m, _MARGIN_QUANTILE)),
        notice_s=float(np.median(encounters.onsets_s[encounters.onsets_s > 0.0])),
        decel_mps2=float(np.median(encounters.decels_mps2)),
    )


def loss_m(met: Sequence[Sequence[MetPeople]], params: ReactionParams, heeding: bool = True) -> float:
    """The loss, or with heeding False that of people who heed nothing."""
    losses = []
    for at_percentiles in met:
        shown = outline(at_percentiles[0].car) if heeding else None
        tried = [_of_each_m(people.walk(params, shown)) for people in at_percentiles]
        losses.append(np.min(tried, axis=0))
    return float(np.mean(np.minimum(np.concatenate(losses), _DISPLACEMENT_M_MAX)))


def _of_each_m(walk: Walk) -> Array:
    """(n,) the mean displacement of each person."""
    apart = np.where(walk.present, np.hypot(*np.moveaxis(walk.places - walk.recorded, 2, 0)), 0.0)
    of_each: Array = apart.sum(axis=0) / np.maximum(1, walk.present.sum(axis=0))
    return of_each
