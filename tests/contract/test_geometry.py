"""Poses and polylines: round trips, and figures that can be worked out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import (
    Pose2,
    arc_lengths,
    compose,
    curvatures,
    inverse,
    pose_at,
    project,
    resample,
    transform_points,
    wrap_angle,
)

COORDINATES = st.floats(-500.0, 500.0)
POSES = st.builds(Pose2, COORDINATES, COORDINATES, st.floats(-math.pi + 1e-6, math.pi))
# East for 10 m, then north for 5 m.
CORNER = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]])
CORNER_S = np.array([0.0, 10.0, 15.0])


def near(one: Pose2, other: Pose2) -> bool:
    apart = abs(wrap_angle(one.yaw_rad - other.yaw_rad))
    return math.hypot(one.x_m - other.x_m, one.y_m - other.y_m) < 1e-8 and apart < 1e-9


@given(st.floats(-100.0, 100.0))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


def test_half_a_turn_is_positive() -> None:
    assert wrap_angle(math.pi) == wrap_angle(-math.pi) == math.pi


@given(POSES, POSES, POSES)
def test_poses_compose_in_any_grouping_and_undo_themselves(a: Pose2, b: Pose2, c: Pose2) -> None:
    assert near(compose(compose(a, b), c), compose(a, compose(b, c)))
    assert near(compose(a, inverse(a)), Pose2(0.0, 0.0, 0.0))
    assert near(compose(inverse(a), compose(a, b)), b)


def test_what_lies_ahead_and_to_the_left_of_a_pose_that_looks_north() -> None:
    seen = compose(Pose2(10.0, 20.0, math.pi / 2), Pose2(3.0, 1.0, math.pi / 2))
    assert near(seen, Pose2(9.0, 23.0, math.pi))


@given(POSES, COORDINATES, COORDINATES)
def test_points_move_as_poses_do(a: Pose2, x: float, y: float) -> None:
    moved = compose(a, Pose2(x, y, 0.0))
    assert transform_points(a, np.array([[x, y]]))[0] == pytest.approx((moved.x_m, moved.y_m))


def test_lengths_along_a_polyline_start_at_zero() -> None:
    assert arc_lengths(CORNER).tolist() == CORNER_S.tolist()


@pytest.mark.parametrize(
    ("place", "found"),
    [
        ((4.0, 1.5), (4.0, 1.5, 0)),
        ((4.0, -1.5), (4.0, -1.5, 0)),
        ((8.5, 3.0), (13.0, 1.5, 1)),
        ((11.5, 3.0), (13.0, -1.5, 1)),
        ((-3.0, 4.0), (0.0, 5.0, 0)),
        ((10.0, 9.0), (15.0, 4.0, 1)),
    ],
)
def test_the_nearest_place_of_a_polyline_and_how_far_to_its_left(
    place: tuple[float, float], found: tuple[float, float, int]
) -> None:
    s_m, d_m, segment = project(CORNER, CORNER_S, *place, 0, 99)
    assert (s_m, abs(d_m), segment) == pytest.approx((found[0], abs(found[1]), found[2]))
    if found[2] or found[0] > 0.0:
        assert math.copysign(1.0, d_m) == math.copysign(1.0, found[1]) or found[0] == 15.0


def test_only_the_named_segments_are_looked_at() -> None:
    assert project(CORNER, CORNER_S, 10.5, 0.1, 0, 1)[:1] == (10.0,)
    assert project(CORNER, CORNER_S, 4.0, 0.0, 1, 2)[::2] == (10.0, 1)
    assert project(CORNER, CORNER_S, 4.0, 0.0, -5, 1)[0] == 4.0
    assert project(CORNER, CORNER_S, 10.0, 3.0, 7, 9)[0] == 13.0


def test_a_point_that_stands_twice_is_passed_over() -> None:
    double = np.array([[0.0, 0.0], [0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [4.0, 4.0]])
    s = arc_lengths(double)
    assert project(double, s, 2.0, 1.0, 0, 9)[:2] == (2.0, 1.0)
    assert pose_at(double, s, 0.0) == (0.0, 0.0, 0.0)
    assert pose_at(double, s, 6.0) == pytest.approx((4.0, 2.0, math.pi / 2))
    for _ in range(3):
        double = np.vstack((double, double[-1:]))
        assert pose_at(double, arc_lengths(double), 8.0) == pytest.approx((4.0, 4.0, math.pi / 2))
    at_one_place = np.ones((3, 2))
    assert pose_at(at_one_place, arc_lengths(at_one_place), 1.0) == (1.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("at_m", "pose"),
    [
        (-1.0, (0.0, 0.0, 0.0)),
        (2.5, (2.5, 0.0, 0.0)),
        (10.0, (10.0, 0.0, math.pi / 2)),
        (12.0, (10.0, 2.0, math.pi / 2)),
        (99.0, (10.0, 5.0, math.pi / 2)),
    ],
)
def test_a_place_on_a_polyline_and_beyond_its_ends(at_m: float, pose: tuple[float, float, float]) -> None:
    assert pose_at(CORNER, CORNER_S, at_m) == pytest.approx(pose)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_curvature_of_a_circle_is_one_over_its_radius_and_positive_to_the_left(side: float) -> None:
    turn = np.linspace(0.0, 1.0, 20)
    circle = np.column_stack((8.0 * np.sin(turn), side * 8.0 * (1.0 - np.cos(turn))))
    assert curvatures(circle) == pytest.approx(np.full(20, side / 8.0), rel=1e-9)


def test_a_line_is_straight_also_where_it_is_too_short_to_tell() -> None:
    assert curvatures(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])).tolist() == [0.0] * 3
    assert curvatures(np.array([[0.0, 0.0], [1.0, 1.0]])).tolist() == [0.0] * 2


@pytest.mark.parametrize(("spacing_m", "count"), [(5.0, 4), (4.9, 5), (100.0, 2), (15.0, 2), (14.9, 3)])
def test_a_resampled_line_keeps_its_ends_and_is_nowhere_coarser(spacing_m: float, count: int) -> None:
    line = resample(CORNER, spacing_m)
    assert len(line) == count
    assert (line[0].tolist(), line[-1].tolist()) == ([0.0, 0.0], [10.0, 5.0])
    assert arc_lengths(line)[1:] - arc_lengths(line)[:-1] == pytest.approx(15.0 / (count - 1), rel=0.5)
    assert np.hypot(*np.diff(line, axis=0).T).max() <= spacing_m + 1e-9
