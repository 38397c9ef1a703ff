"""How well found boxes are those that are there: average precision by kind, and the error of velocities."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from vehicle_agent.perception.pillars.overlap import iou


class FoundBoxes(NamedTuple):
    """kinds (n,), scores (n,), boxes (n, 8) of one scan; the boxes as in `LabeledScan`."""

    kinds: NDArray[np.int64]
    scores: Array
    boxes: Array


class TrueBoxes(NamedTuple):
    """kinds (m,), boxes (m, 8), counts (m,) bool: those that must be found; the others are neither."""

    kinds: NDArray[np.int64]
    boxes: Array
    counts: NDArray[np.bool_]


class Precision(NamedTuple):
    """average_precision and recall_ratio 0 to 1; boxes that counted; velocity_errors_mps (k,) of matches."""

    average_precision: float
    recall_ratio: float
    boxes: int
    velocity_errors_mps: Array


# How near two boxes (8,) are, 0 to 1.
Nearness = Callable[[Array, Array], float]


def overlap(first: Array, second: Array) -> float:
    """Their intersection over union on the ground."""
    return float(iou(first[:5], second[:5]))


def closeness(first: Array, second: Array) -> float:
    """1 for the same middle, 0.5 at 0.5 m, 0 from 1 m on."""
    return float(max(0.0, 1.0 - np.hypot(first[0] - second[0], first[1] - second[1])))


def average_precision(
    scans: list[tuple[FoundBoxes, TrueBoxes]], kind: int, near_min: float, nearness: Nearness = overlap
) -> Precision:
    """Average precision of one kind over all scans.

    The best found boxes choose first; each takes the nearest true box of the kind that is free and at least
    near_min. One that takes a box which does not count is left out. The precision is the area under its curve
    over all recalls, made monotone (PASCAL VOC 2010). Velocity errors: of matches with a finite velocity.
    """
    scores, is_right, errors, count = [], [], [], 0
    for found, true in scans:
        rows = np.flatnonzero(true.kinds == kind)
        count += int(true.counts[rows].sum())
        free = np.ones(len(rows), dtype=bool)
        mine = np.flatnonzero(found.kinds == kind)
        for row in mine[np.argsort(-found.scores[mine], kind="stable")]:
            near = [nearness(found.boxes[row], true.boxes[other]) for other in rows]
            near = [value if is_free else -1.0 for value, is_free in zip(near, free, strict=True)]
            best = int(np.argmax(near)) if near else -1
            if best < 0 or near[best] < near_min:
                scores.append(found.scores[row])
                is_right.append(False)
                continue
            free[best] = False
            if not true.counts[rows[best]]:
                continue
            scores.append(found.scores[row])
            is_right.append(True)
            apart = found.boxes[row, 6:8] - true.boxes[rows[best], 6:8]
            if np.isfinite(apart).all():
                errors.append(float(np.hypot(*apart)))
    order = np.argsort(-np.array(scores), kind="stable")
    right = np.cumsum(np.array(is_right, dtype=np.float64)[order])
    if not count or not len(right):
        return Precision(0.0, 0.0, count, np.array(errors))
    precision = right / np.arange(1, len(right) + 1)
    precision = np.maximum.accumulate(precision[::-1])[::-1]
    recall = right / count
    area = float((np.diff(recall, prepend=0.0) * precision).sum())
    return Precision(area, float(recall[-1]), count, np.array(errors))
