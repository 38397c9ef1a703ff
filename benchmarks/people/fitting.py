"""The fit of the people's reaction to recordings: random search, and the mean of the best tenth.

The loss of a set of parameters is the mean over people in a car's way of their mean displacement from the
recording, on desired ways. Free speeds are not known: the best of three percentiles of a person's own speeds
counts, for every set alike. The landscape is flat and rough around its minimum, so the minimum itself would
fit the noise of single walks.
"""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.people.samples import Drive, outline
from contract.geometry import Array
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.reproduction import Walk, recreations

FREE_PERCENTILES = (55.0, 70.0, 85.0)
# Where each parameter is searched.
RANGES = {
    "margin_m": (0.05, 0.8),
    "notice_s": (0.8, 3.2),
    "decel_mps2": (0.4, 2.5),
    "sidestep_mps": (0.2, 1.2),
    "sidestep_cost": (0.2, 2.0),
}
_DISPLACEMENT_M_MAX = 2.0
_BEST_SHARE = 0.1


def fitted(drives: Sequence[Drive], tries: int, seed: int, tell: Callable[[str], None]) -> ReactionParams:
    """The mean of the best tenth of `tries` random sets of parameters."""
    rng = np.random.default_rng([seed, *b"people"])
    sets = np.column_stack([rng.uniform(low, high, tries) for low, high in RANGES.values()])
    losses = np.empty(tries)
    for k, row in enumerate(sets):
        losses[k] = loss_m(drives, _params(row))
        tell(f"{k + 1} of {tries}: {losses[k]:.4f} m, least {losses[: k + 1].min():.4f} m")
    best = np.argsort(losses, kind="stable")[: max(1, round(_BEST_SHARE * tries))]
    return _params(sets[best].mean(axis=0))


def _params(row: Array) -> ReactionParams:
    return ReactionParams(**{name: float(value) for name, value in zip(RANGES, row, strict=True)})


def loss_m(drives: Sequence[Drive], params: ReactionParams, heeding: bool = True) -> float:
    """The loss, or with heeding False that of people who heed nothing."""
    losses: list[Array] = []
    for drive in drives:
        people = [track for track in drive.clip.tracks if not track.is_driven]
        tried = []
        for percentile in FREE_PERCENTILES:
            walks = recreations(people, drive.car, drive.clip.ends_s, outline(drive.car), params, percentile)
            tried.append(_of_each_m(walks[0] if heeding else walks[1]))
        losses.append(np.min(tried, axis=0))
    return float(np.mean(np.minimum(np.concatenate(losses), _DISPLACEMENT_M_MAX)))


def _of_each_m(walk: Walk) -> Array:
    """(n,) the mean displacement of each person."""
    apart = np.where(walk.present, np.hypot(*np.moveaxis(walk.places - walk.recorded, 2, 0)), 0.0)
    of_each: Array = apart.sum(axis=0) / np.maximum(1, walk.present.sum(axis=0))
    return of_each
