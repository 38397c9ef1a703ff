"""The gate's own look ahead of the bumper."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.gate.footprint import distance_on_arc, is_met_on_arc


def test_the_distance_is_measured_along_the_arc() -> None:
    left, right = np.array([[6.0, 3.0]]), np.array([[6.0, -3.0]])
    assert distance_on_arc(left, 0.15, 3.5, 0.9) < 4.0
    assert math.isinf(distance_on_arc(right, 0.15, 3.5, 0.9))
    assert distance_on_arc(right, -0.15, 3.5, 0.9) < 4.0
    assert distance_on_arc(np.array([[5.0, 0.0]]), 0.0, 3.5, 0.9) == 1.5


def test_points_alongside_or_behind_the_bumper_do_not_count() -> None:
    beside = np.array([[1.0, 1.0], [-2.0, 0.0], [3.0, -0.5]])
    assert math.isinf(distance_on_arc(beside, 0.0, 3.5, 0.9))


def met_by_steps(x: float, y: float, curvature_1pm: float, look_m: float) -> float:
    """Travel until the body, moved along the arc in steps of a centimetre, covers the point."""
    for way in np.arange(0.0, look_m, 0.01):
        yaw = curvature_1pm * way
        dx = x - np.sin(yaw) / curvature_1pm
        dy = y - (1.0 - np.cos(yaw)) / curvature_1pm
        ahead, aside = dx * np.cos(yaw) + dy * np.sin(yaw), dy * np.cos(yaw) - dx * np.sin(yaw)
        if 0.0 <= ahead <= 3.5 and abs(aside) <= 0.8:
            return float(way)
    return math.inf


_NEAR_M = ((0.0, 0.02), (0.0, -0.02), (0.02, 0.0), (-0.02, 0.0))


@settings(deadline=None, max_examples=60)
@given(st.floats(3.6, 8.0), st.floats(-5.0, 5.0), st.floats(0.03, 0.2), st.booleans())
def test_the_distance_on_an_arc_ends_where_the_body_touches(
    x: float, y: float, bend_1pm: float, left: bool
) -> None:
    curvature = bend_1pm if left else -bend_1pm
    distance_m = distance_on_arc(np.array([[x, y]]), curvature, 3.5, 0.8)
    stepped = met_by_steps(x, y, curvature, 5.0)
    near = [math.isinf(met_by_steps(x + dx, y + dy, curvature, 5.0)) for dx, dy in _NEAR_M]
    # Steps of a centimetre do not see what is only just touched.
    grazed = any(near) and not all(near)
    assert grazed or distance_m == pytest.approx(stepped, abs=0.03) or min(distance_m, stepped) > 4.9


def test_a_person_a_metre_from_the_inner_corner_is_not_touched_yet() -> None:
    assert distance_on_arc(np.array([[3.46, 1.88]]), 0.157, 3.5, 0.815) > 1.0


def met(x: float, y: float, vx: float, vy: float, curvature_1pm: float = 0.0, speed_mps: float = 4.0) -> bool:
    return bool(
        is_met_on_arc(
            np.array([[x, y]]), np.array([[vx, vy]]), curvature_1pm, speed_mps, 0.27, 5.6, 0.1, 3.5, 0.8
        )
    )


@pytest.mark.parametrize("curvature", [0.0, 0.05, -0.05])
def test_a_standing_obstacle_is_met_within_the_stopping_distance(curvature: float) -> None:
    stopping_m = 4.0 * 0.27 + 4.0**2 / (2.0 * 5.6)
    assert met(3.5 + stopping_m, 0.0, 0.0, 0.0, curvature)
    assert not met(3.5 + stopping_m + 0.3, 0.0, 0.0, 0.0, curvature)


def test_what_stands_within_the_margin_beyond_the_stopping_way_is_met_too() -> None:
    stopping_m = 4.0 * 0.27 + 4.0**2 / (2.0 * 5.6)
    assert met(3.5 + stopping_m + 0.08, 0.0, 0.0, 0.0)
    assert not met(3.5 + stopping_m + 0.12, 0.0, 0.0, 0.0)


def test_a_vehicle_that_creeps_meets_who_is_at_its_bumper() -> None:
    """It would stop within 10 ms; the person is in its path all the same."""
    person = np.array([[3.52, 0.0]])
    assert is_met_on_arc(person, np.zeros((1, 2)), 0.0, 0.05, 0.0, 5.6, 0.1, 3.5, 0.8)


def test_a_person_who_leaves_the_way_before_the_bumper_arrives_is_not_met() -> None:
    assert not met(5.5, 0.2, 0.0, -4.0)
    assert not met(5.5, 0.2, 4.0, 0.0)
    assert met(5.5, 0.2, 0.0, -0.5)
    assert met(5.5, 0.2, -1.0, 0.0)


def test_the_braking_of_the_vehicle_is_reckoned_with() -> None:
    """Somebody walks ahead at 1.6 m/s: braking from 3 m/s lets them gain room, driving on would not."""
    assert not met(3.5 + 0.75, 0.0, 1.6, 0.0, speed_mps=3.0)
    assert met(3.5 + 0.5, 0.0, 1.6, 0.0, speed_mps=3.0)


def test_somebody_beside_the_way_hides_nobody_who_is_in_it() -> None:
    beside, inside = (5.0, 3.0), (5.0, 0.0)
    for places in ((beside, inside), (inside, beside)):
        assert is_met_on_arc(np.array(places), np.zeros((2, 2)), 0.0, 4.0, 0.27, 5.6, 0.1, 3.5, 0.8)


def test_somebody_who_comes_into_the_way_of_one_who_leaves_it_is_no_reason_to_brake_yet() -> None:
    comes, leaves = (5.5, 2.0, 0.0, -3.0), (5.5, 0.2, 0.0, -4.0)
    for people in ((comes, leaves), (leaves, comes)):
        rows = np.array(people)
        assert not is_met_on_arc(rows[:, :2], rows[:, 2:], 0.0, 4.0, 0.27, 5.6, 0.1, 3.5, 0.8)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_person_alongside_the_outer_front_corner_is_passed(side: float) -> None:
    assert math.isinf(distance_on_arc(np.array([[3.46, side * 0.82]]), -side * 0.054, 3.5, 0.815))
