"""What an object is, by its size, height and shape. Gates with soft edges; no network."""

from typing import NamedTuple

import numpy as np

from contract.geometry import Array, IntArray
from vehicle_agent.perception.points.boxes import (
    ABOVE_CHEST,
    B_LOW,
    B_TALL,
    B_TOP,
    BX,
    BY,
    GAP,
    LENGTH,
    RETURNS,
    WIDTH,
)
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, TRACK_KINDS, VEHICLE


class KindGates(NamedTuple):
    """Sizes in m. Each gate falls from 1 to 0 over its softness.

    ring_rad        angle between the lidar's rings: a person's head may be so far above the highest return
    person_*        height, length and width of the visible part of a person; how softly a child is one
    cyclist_*, car_*   the same of riders on their cycle, and of cars, trucks and shuttles
    whole_car_*     of a car of which roof or both sides are seen
    tall_m          what goes on above this is a post, a trunk or a wall
    flat_m          cells of a car lie so near to its sides, in the mean
    hidden_m        so much of the lower part may be hidden
    """

    ring_rad: float = 0.015
    person_top_m: tuple[float, float] = (1.4, 2.05)
    person_soft_m: float = 0.35
    person_length_m: tuple[float, float] = (0.2, 0.95)
    person_width_m: tuple[float, float] = (0.05, 0.75)
    cyclist_top_m: tuple[float, float] = (1.4, 2.1)
    cyclist_length_m: tuple[float, float] = (1.1, 2.1)
    cyclist_width_m: tuple[float, float] = (0.1, 0.9)
    car_top_m: tuple[float, float] = (1.25, 3.6)
    car_length_m: tuple[float, float] = (1.5, 9.0)
    car_width_m: tuple[float, float] = (0.1, 2.7)
    whole_car_length_m: tuple[float, float] = (3.2, 8.5)
    whole_car_width_m: tuple[float, float] = (1.4, 2.6)
    tall_m: float = 2.15
    flat_m: float = 0.3
    hidden_m: float = 1.45


def kind_scores(boxes: Array, gates: KindGates) -> Array:
    """(n, 4) how well each row of `object_boxes` fits each of TRACK_KINDS, 0 to 1; `other`: the rest."""
    ring_m = gates.ring_rad * np.hypot(boxes[:, BX], boxes[:, BY])
    top, tall = boxes[:, B_TOP], boxes[:, B_TALL]
    length, width = boxes[:, LENGTH], boxes[:, WIDTH]
    # Something nearer, or the vehicle's own side, may hide the legs.
    stands = _below(boxes[:, B_LOW], gates.hidden_m, 0.2)
    # Where nothing is between the top and the vehicle's height, what is higher is another thing: a crown.
    short = _below(np.where(top < gates.person_top_m[1] - 0.1, top, tall), gates.tall_m, 0.15)
    upright = np.clip(boxes[:, ABOVE_CHEST] / np.maximum(1.0, 0.25 * boxes[:, RETURNS]), 0.0, 1.0)
    scores = np.zeros((len(boxes), len(TRACK_KINDS)))
    scores[:, PEDESTRIAN] = (
        np.minimum(
            _within(top, (gates.person_top_m[0], 9.0), gates.person_soft_m, ring_m),
            _below(top, gates.person_top_m[1], 0.12),
        )
        * _within(length, gates.person_length_m, 0.1)
        * _within(width, gates.person_width_m, 0.1)
        * short
        * stands
        * upright
    )
    scores[:, CYCLIST] = (
        _within(top, gates.cyclist_top_m, 0.12, ring_m)
        * _within(length, gates.cyclist_length_m, 0.15)
        * _within(width, gates.cyclist_width_m, 0.1)
        * short
        * stands
    )
    # Of a car whose roof is seen the cells fill the box; a narrower thing must be flat sides.
    whole = _within(length, gates.whole_car_length_m, 0.3) * _within(width, gates.whole_car_width_m, 0.2)
    scores[:, VEHICLE] = (
        _within(top, gates.car_top_m, 0.1, ring_m)
        * _within(length, gates.car_length_m, 0.3)
        * _within(width, gates.car_width_m, 0.2)
        * np.maximum(whole, _below(boxes[:, GAP], gates.flat_m, 0.1))
        * np.maximum(whole, short)
        * stands
    )
    scores[:, OTHER] = 1.0 - scores.max(axis=1)
    return scores


def best_kinds(scores: Array) -> tuple[IntArray, Array]:
    """((n,) kinds, (n,) their scores)."""
    kinds = np.argmax(scores, axis=1)
    return kinds.astype(np.int64), scores[np.arange(len(kinds)), kinds]


def _below(values: Array, most: float, soft: float) -> Array:
    return np.clip(1.0 - (values - most) / soft, 0.0, 1.0)


def _within(values: Array, span: tuple[float, float], soft: float, missing: Array | float = 0.0) -> Array:
    """1 inside the span, falling to 0 over `soft` beyond it; values may be short by `missing`."""
    return np.clip(1.0 - (span[0] - missing - values) / soft, 0.0, 1.0) * _below(values, span[1], soft)
