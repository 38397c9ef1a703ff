"""Average precision by hand, and what it must never do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE
from workshop.detector.average_precision import (
    FoundBoxes,
    TrueBoxes,
    average_precision,
    closeness,
)


def box(x: float, y: float = 0.0, vx: float = 0.0) -> list[float]:
    return [x, y, 0.0, 4.0, 2.0, 1.5, vx, 0.0]


def found(*rows: tuple[list[float], float, int]) -> FoundBoxes:
    return FoundBoxes(
        np.array([kind for _, _, kind in rows], dtype=np.int64),
        np.array([score for _, score, _ in rows]),
        np.array([values for values, _, _ in rows]).reshape(-1, 8),
    )


def true(*rows: tuple[list[float], int, bool]) -> TrueBoxes:
    return TrueBoxes(
        np.array([kind for _, kind, _ in rows], dtype=np.int64),
        np.array([values for values, _, _ in rows]).reshape(-1, 8),
        np.array([counts for _, _, counts in rows], dtype=bool),
    )


def test_one_right_one_wrong_and_one_missed() -> None:
    scan = (
        found((box(0.0), 0.9, VEHICLE), (box(50.0), 0.8, VEHICLE)),
        true((box(0.2), VEHICLE, True), (box(20.0), VEHICLE, True)),
    )
    precision = average_precision([scan], VEHICLE, 0.5)
    # Recall 1/2 at precision 1, then nothing.
    assert precision.average_precision == pytest.approx(0.5)
    assert precision.recall_ratio == pytest.approx(0.5)
    assert precision.boxes == 2


def test_a_wrong_box_that_is_surer_costs_precision() -> None:
    scan = (
        found((box(50.0), 0.9, VEHICLE), (box(0.0), 0.8, VEHICLE)),
        true((box(0.0), VEHICLE, True)),
    )
    assert average_precision([scan], VEHICLE, 0.5).average_precision == pytest.approx(0.5)


def test_a_second_box_on_the_same_object_is_wrong() -> None:
    scan = (
        found((box(0.0), 0.9, VEHICLE), (box(0.1), 0.8, VEHICLE), (box(20.0), 0.7, VEHICLE)),
        true((box(0.0), VEHICLE, True), (box(20.0), VEHICLE, True)),
    )
    assert average_precision([scan], VEHICLE, 0.5).average_precision == pytest.approx(0.5 + 0.5 * 2 / 3)


def test_objects_that_do_not_count_are_neither_right_nor_wrong() -> None:
    scan = (
        found((box(0.0), 0.9, VEHICLE), (box(20.0), 0.95, VEHICLE)),
        true((box(0.0), VEHICLE, True), (box(20.0), VEHICLE, False)),
    )
    precision = average_precision([scan], VEHICLE, 0.5)
    assert precision.average_precision == 1.0
    assert precision.boxes == 1


def test_kinds_are_told_apart_and_an_empty_answer_is_worth_nothing() -> None:
    scan = (found((box(0.0), 0.9, CYCLIST)), true((box(0.0), VEHICLE, True)))
    assert average_precision([scan], VEHICLE, 0.5).average_precision == 0.0
    assert average_precision([scan], PEDESTRIAN, 0.5).boxes == 0


def test_middles_half_a_metre_apart_are_just_near_enough() -> None:
    scan = (found((box(0.49), 0.9, VEHICLE)), true((box(0.0), VEHICLE, True)))
    assert average_precision([scan], VEHICLE, 0.5, closeness).average_precision == 1.0
    farther = (found((box(0.51), 0.9, VEHICLE)), true((box(0.0), VEHICLE, True)))
    assert average_precision([farther], VEHICLE, 0.5, closeness).average_precision == 0.0


def test_velocity_errors_are_of_right_boxes_with_a_velocity() -> None:
    scan = (
        found(
            (box(0.0, vx=1.0), 0.9, VEHICLE), (box(20.0, vx=np.nan), 0.8, VEHICLE), (box(90.0), 0.7, VEHICLE)
        ),
        true((box(0.0, vx=1.5), VEHICLE, True), (box(20.0), VEHICLE, True)),
    )
    assert average_precision([scan], VEHICLE, 0.5).velocity_errors_mps.tolist() == [0.5]


@given(
    places=st.lists(st.integers(0, 30), unique=True, min_size=1, max_size=12),
    found_share=st.floats(0.0, 1.0),
    seed=st.integers(0, 99),
)  # fmt: skip
def test_without_wrong_boxes_it_is_the_recall(places: list[int], found_share: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = [(box(10.0 * place), VEHICLE, True) for place in places]
    kept = [row for row in rows if rng.random() < found_share]
    scan = (found(*((values, float(rng.random()), VEHICLE) for values, _, _ in kept)), true(*rows))
    precision = average_precision([scan], VEHICLE, 0.5)
    assert precision.average_precision == pytest.approx(len(kept) / len(rows))
