"""How probable each outline of a board is, after all chords that were seen of it (Bayes' rule on a grid)."""

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.perception.signs.outlines import BOTTOMS_M, KINDS, OUTLINES, SIZES_M, WIDTHS_M, widths_at

# A chord that fits no outline: as probable as one that is off by so many standard deviations.
_UNKNOWN_SIGMAS = 3.0
_UNKNOWN_SHARE = 0.15
# Gross errors: a branch before the board, dirt on it.
_OUTLIER_SIGMAS = 4.0


class Evidence(msgspec.Struct, frozen=True):
    """log_odds (h, bottoms) float32 of each hypothesis of outline, size and height of the lowest point;
    unknown: of something else.
    """

    log_odds: np.ndarray
    unknown: float


def no_evidence() -> Evidence:
    """Every outline of every size and at every height equally probable, and one share for all else.

    Plates have the most sizes: a board of which only a part has been seen is a plate before it is a stop.
    """
    prior = -float(np.log(WIDTHS_M.shape[0] * len(BOTTOMS_M) * (1.0 + _UNKNOWN_SHARE)))
    table = np.full((WIDTHS_M.shape[0], len(BOTTOMS_M)), prior, np.float32)
    return Evidence(table, float(np.log(_UNKNOWN_SHARE / (1.0 + _UNKNOWN_SHARE))))


def with_chords(evidence: Evidence, chords: Array, weight: float, drift: float) -> Evidence:
    """The evidence after the chords (k, 5) of one more scan, as `chords_of` gives them.

    weight  0..1: scans from nearly one place say nearly the same, since the same firings meet the board
    drift   share of the probability that moves to the height a step above, and below: the vehicle pitches on
            its way
    """
    table = evidence.log_odds.astype(np.float64)
    if drift > 0.0:
        likely = np.exp(table - table.max())
        moved = (1.0 - 2.0 * drift) * likely
        moved[:, 1:] += drift * likely[:, :-1]
        moved[:, :-1] += drift * likely[:, 1:]
        table = np.log(np.maximum(moved, 1e-30)) + table.max()
    unknown = evidence.unknown
    for width_m, left_m, right_m, deviation_m, _ in chords:
        expected = 0.5 * (widths_at(float(left_m)) + widths_at(float(right_m)))
        # The height itself is known to half a step.
        sigmas = np.minimum(np.abs(expected - width_m) / deviation_m, _OUTLIER_SIGMAS)
        table -= 0.5 * weight * sigmas**2
        unknown -= 0.5 * weight * _UNKNOWN_SIGMAS**2
    top = max(float(table.max()), unknown)
    return Evidence((table - top).astype(np.float32), unknown - top)


def probabilities(evidence: Evidence) -> dict[str, float]:
    """By outline, and of "unknown"; together 1."""
    shares = np.exp(evidence.log_odds.astype(np.float64)).sum(axis=1)
    totals = np.bincount(KINDS, weights=shares, minlength=len(OUTLINES))
    unknown = float(np.exp(evidence.unknown))
    whole = float(totals.sum()) + unknown
    found = {name: float(total) / whole for name, total in zip(OUTLINES, totals, strict=True)}
    return found | {"unknown": unknown / whole}


def likely_size_m(evidence: Evidence) -> float:
    """The size of the most probable outline and size, as `outlines` measures it."""
    return float(SIZES_M[int(np.argmax(np.exp(evidence.log_odds.astype(np.float64)).sum(axis=1)))])
