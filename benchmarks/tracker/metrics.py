"""HOTA and IDF1 of tracks against the truth.

Luiten et al., "HOTA: a higher order metric for evaluating multi-object tracking" (2021), equations 1 to 9;
Ristani et al., "Performance measures and a data set for multi-target, multi-camera tracking" (2016).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from contract.geometry import Array, IntArray

# Thresholds of similarity over which HOTA is the mean; IDF1 has one.
ALPHAS = tuple(0.05 * k for k in range(1, 20))
_IDF1_SIMILARITY = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class FrameTracks:
    """One frame: truth_ids (n,), truth (n, 2); ids (m,), places (m, 2); reach_m (n,): similarity 0."""

    truth_ids: IntArray
    truth: Array
    ids: IntArray
    places: Array
    reach_m: Array

    def similarity(self) -> Array:
        """(n, m) from 1 at the same place down to 0 at reach_m."""
        apart = np.hypot(
            self.truth[:, None, 0] - self.places[None, :, 0], self.truth[:, None, 1] - self.places[None, :, 1]
        )
        near: Array = np.maximum(0.0, 1.0 - apart / self.reach_m[:, None])
        return near


@dataclass(frozen=True, slots=True)
class TrackScores:
    """hota, detection, association, idf1 from 0 to 1; switches: truths whose track changed."""

    hota: float
    detection: float
    association: float
    idf1: float
    switches: int


def scores_of(frames: Sequence[FrameTracks]) -> TrackScores:
    """The scores of a sequence; 1 for nothing in the truth and nothing tracked."""
    truth_of = _numbers(frame.truth_ids for frame in frames)
    track_of = _numbers(frame.ids for frame in frames)
    pairs = [
        (
            np.array([truth_of[int(i)] for i in frame.truth_ids], np.int64),
            np.array([track_of[int(i)] for i in frame.ids], np.int64),
            frame.similarity(),
        )
        for frame in frames
    ]
    truth_count = _counts((rows for rows, _, _ in pairs), len(truth_of))
    track_count = _counts((columns for _, columns, _ in pairs), len(track_of))
    if not len(truth_of) and not len(track_of):
        return TrackScores(1.0, 1.0, 1.0, 1.0, 0)
    aligned = _global_alignment(pairs, truth_count, track_count)
    by_alpha = [_hota_at(alpha, pairs, aligned, truth_count, track_count) for alpha in ALPHAS]
    hota, detection, association = np.mean(by_alpha, axis=0)
    return TrackScores(
        float(hota),
        float(detection),
        float(association),
        _idf1(pairs, truth_count, track_count),
        _switches(pairs),
    )


Pairs = list[tuple[IntArray, IntArray, Array]]


def _numbers(ids: Iterable[IntArray]) -> dict[int, int]:
    known: dict[int, int] = {}
    for frame_ids in ids:
        for one in frame_ids.tolist():
            known.setdefault(one, len(known))
    return known


def _counts(numbers: Iterable[IntArray], size: int) -> Array:
    total: Array = np.zeros(size)
    for one in numbers:
        total += np.bincount(one, minlength=size)
    return total


def _global_alignment(pairs: Pairs, truth_count: Array, track_count: Array) -> Array:
    """(truths, tracks) how often two are alike over the sequence: HOTA's matching prefers such pairs."""
    alike: Array = np.zeros((len(truth_count), len(track_count)))
    for rows, columns, similarity in pairs:
        total = similarity.sum(axis=1)[:, None] + similarity.sum(axis=0)[None, :] - similarity
        alike[np.ix_(rows, columns)] += similarity / np.maximum(total, 1e-12)
    return alike / np.maximum(truth_count[:, None] + track_count[None, :] - alike, 1e-12)


def _hota_at(
    alpha: float, pairs: Pairs, aligned: Array, truth_count: Array, track_count: Array
) -> tuple[float, float, float]:
    """(HOTA, detection accuracy, association accuracy) at one threshold."""
    matches: Array = np.zeros_like(aligned)
    for rows, columns, similarity in pairs:
        score = np.where(similarity >= alpha, aligned[np.ix_(rows, columns)] + 1e-6 * similarity + 1e-9, 0.0)
        matched_rows, matched_columns = linear_sum_assignment(-score)
        good = score[matched_rows, matched_columns] > 0.0
        matches[rows[matched_rows[good]], columns[matched_columns[good]]] += 1.0
    hits = matches.sum()
    detection = hits / max(truth_count.sum() + track_count.sum() - hits, 1.0)
    accuracy = matches / np.maximum(truth_count[:, None] + track_count[None, :] - matches, 1.0)
    association = float((matches * accuracy).sum() / max(hits, 1.0))
    return float(np.sqrt(detection * association)), float(detection), association


def _idf1(pairs: Pairs, truth_count: Array, track_count: Array) -> float:
    """Share of places with the right identity, by the best pairing of truths and tracks over the sequence."""
    matches: Array = np.zeros((len(truth_count), len(track_count)))
    for rows, columns, similarity in pairs:
        matches[np.ix_(rows, columns)] += similarity >= _IDF1_SIMILARITY
    rows, columns = linear_sum_assignment(-matches)
    return float(2.0 * matches[rows, columns].sum() / (truth_count.sum() + track_count.sum()))


def _switches(pairs: Pairs) -> int:
    """How often a truth is matched to another track than the last time."""
    last: dict[int, int] = {}
    switches = 0
    for rows, columns, similarity in pairs:
        for row, column in zip(*linear_sum_assignment(-similarity), strict=True):
            if similarity[row, column] < _IDF1_SIMILARITY:
                continue
            truth, track = int(rows[row]), int(columns[column])
            switches += last.get(truth, track) != track
            last[truth] = track
    return switches
