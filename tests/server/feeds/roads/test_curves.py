"""Turns, loops and smoothed lines."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import arc_lengths, wrap_angle
from server.feeds.roads.lanes.curves import (
    connect,
    end_poses,
    loop,
    offset,
    peak_curvature,
    step_aside,
)
from server.feeds.roads.lanes.smoothing import largest_deviation_m, smooth


def _pose(x: float, y: float, degrees: float) -> np.ndarray:
    return np.array([x, y, math.radians(degrees)])


@settings(max_examples=40, deadline=None)
@given(st.floats(-110.0, 110.0), st.floats(12.0, 30.0))
def test_a_turn_with_room_begins_and_ends_in_its_poses_and_keeps_the_radius(
    turn_deg: float, leg_m: float
) -> None:
    turn = math.radians(turn_deg)
    start, end = _pose(-leg_m, 0.0, 0.0), np.array([leg_m * math.cos(turn), leg_m * math.sin(turn), turn])
    points = connect(start, end, 1.0 / 5.5)
    if points is None:
        assert leg_m < 5.5 * math.tan(abs(turn) / 2.0) * 1.25
        return
    assert peak_curvature(points) <= 1.0 / 5.4
    first, last = end_poses(points)
    assert first[:2] == pytest.approx(start[:2])
    assert last[:2] == pytest.approx(end[:2])
    assert abs(wrap_angle(float(first[2] - start[2]))) < 0.04
    assert abs(wrap_angle(float(last[2] - end[2]))) < 0.04


def test_a_turn_without_room_is_refused() -> None:
    assert connect(_pose(-3.0, 0.0, 0.0), _pose(0.0, 3.0, 90.0), 0.2) is None


@pytest.mark.parametrize("left_first", [True, False])
@pytest.mark.parametrize("apart_m", [0.0, 3.0])
def test_a_loop_comes_back_in_the_opposite_direction(left_first: bool, apart_m: float) -> None:
    start, end = _pose(0.0, 0.0, 0.0), _pose(0.0, apart_m, 180.0)
    arcs = loop(start, end, 6.0, left_first)
    assert arcs is not None
    points = smooth(arcs, 1.0 / 5.2, held_m=0.5)
    assert points is not None
    assert peak_curvature(points) <= 1.0 / 5.1
    first, last = end_poses(points)
    assert first == pytest.approx(start, abs=0.06)
    assert abs(wrap_angle(float(last[2]) - math.pi)) < 0.06
    assert arc_lengths(points)[-1] < 60.0


def test_smoothing_keeps_the_ends_and_stays_near_a_noisy_line() -> None:
    rng = np.random.default_rng(1)
    x = np.linspace(0.0, 200.0, 21)
    noisy = np.column_stack((x, rng.normal(0.0, 0.5, 21)))
    line = smooth(noisy, 1.0 / 6.5)
    assert line is not None
    assert peak_curvature(line) <= 1.0 / 6.4
    assert line[0] == pytest.approx(noisy[0])
    assert line[-1] == pytest.approx(noisy[-1])
    assert largest_deviation_m(line, noisy) < 1.0


def test_smoothing_rounds_a_right_angle_and_leaves_the_rest_alone() -> None:
    corner = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 60.0]])
    line = smooth(corner, 1.0 / 6.5)
    assert line is not None
    assert 0.8 < largest_deviation_m(line, corner) < 3.0
    assert largest_deviation_m(line[line[:, 0] < 35.0], corner) < 0.1


def test_a_line_that_turns_back_on_itself_cannot_be_smoothed() -> None:
    assert smooth(np.array([[0.0, 0.0], [40.0, 0.0], [0.0, 0.5]]), 1.0 / 5.3) is None


def test_a_lay_by_leaves_and_joins_without_a_kink() -> None:
    straight = np.column_stack((np.linspace(0.0, 70.0, 141), np.zeros(141)))
    line = offset(straight, step_aside(arc_lengths(straight), 20.0, -3.2))
    assert line[0] == pytest.approx([0.0, 0.0])
    assert line[70] == pytest.approx([35.0, -3.2])
    assert peak_curvature(line) < 1.0 / 15.0
