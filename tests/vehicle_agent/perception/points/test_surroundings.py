"""Outlines, the unknown height of a sensor, and points of a vehicle that drives."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.vehicle_agent.perception.points.bodies import person, road, scan, sides
from vehicle_agent.perception.points.deskew import straightened
from vehicle_agent.perception.points.level import NoGroundError, above_plane, ground_plane
from vehicle_agent.perception.points.outlines import outline


def test_the_inside_of_a_bush_is_left_out_and_its_edge_stays() -> None:
    cells = np.zeros((30, 30), np.bool_)
    cells[5:20, 6:16] = np.random.default_rng(1).random((15, 10)) < 0.7
    edge = outline(cells, 5)
    assert not edge[8:17, 9:13].any()
    assert (edge[5] == cells[5]).all()
    assert (edge[:, 6] == cells[:, 6]).all()


@settings(max_examples=50, deadline=None)
@given(rows=st.lists(st.tuples(st.integers(2, 27), st.integers(2, 27)), max_size=12))
def test_an_outline_adds_nothing_and_keeps_every_thing(rows: list[tuple[int, int]]) -> None:
    cells = np.zeros((30, 30), np.bool_)
    for row, column in rows:
        cells[row, column] = True
    edge = outline(cells, 5)
    assert not (edge & ~cells).any()
    if cells.any():
        first = np.argwhere(cells)[0]
        assert edge[tuple(first)], "the first cell of all is at an edge"


def test_a_wall_two_cells_thick_stays_whole() -> None:
    cells = np.zeros((30, 30), np.bool_)
    cells[10:12] = True
    assert outline(cells, 5)[10:12].all()


@settings(max_examples=20, deadline=None)
@given(height=st.floats(0.8, 3.0), pitch=st.floats(-0.04, 0.04), roll=st.floats(-0.04, 0.04))
def test_the_ground_of_an_unknown_sensor_is_found(height: float, pitch: float, roll: float) -> None:
    points = scan(road(), person(5.0, 2.0), sides(9.0, -4.0, 0.2, 4.4, 1.8, 0.2, 1.4))
    points[:, 2] += (-height + pitch * points[:, 0] + roll * points[:, 1]).astype(np.float32)
    plane = ground_plane(points)
    assert plane == pytest.approx((-height, pitch, roll), abs=0.02)
    assert np.abs(above_plane(points, plane)[:1000, 2]).max() < 0.1


def test_a_sensor_that_sees_no_ground_says_so() -> None:
    with pytest.raises(NoGroundError):
        ground_plane(np.array([[5.0, 0.0, 1.0]] * 200))


@pytest.mark.parametrize(("speed", "yaw_rate"), [(3.0, 0.0), (3.0, 0.4), (0.0, -0.5)])
def test_a_post_seen_all_through_a_turn_is_one_place(speed: float, yaw_rate: float) -> None:
    offsets_s = np.linspace(-0.1, 0.0, 11).astype(np.float32)
    post_at_stamp = np.array([8.0, 3.0])
    points = []
    for offset in offsets_s.tolist():
        yaw = yaw_rate * offset
        x, y = (speed * offset, 0.0) if yaw_rate == 0.0 else (
            speed / yaw_rate * math.sin(yaw), speed / yaw_rate * (1.0 - math.cos(yaw)),
        )  # fmt: skip
        dx, dy = post_at_stamp - [x, y]
        points.append(
            (math.cos(yaw) * dx + math.sin(yaw) * dy, -math.sin(yaw) * dx + math.cos(yaw) * dy, 1.0)
        )
    moved = straightened(np.array(points, np.float32), offsets_s, speed, yaw_rate)
    assert moved[:, :2] == pytest.approx(np.tile(post_at_stamp, (11, 1)), abs=1e-3)


def test_points_without_times_are_refused() -> None:
    with pytest.raises(ValueError, match="2 points and 3 times"):
        straightened(np.zeros((2, 3), np.float32), np.zeros(3, np.float32), 1.0, 0.0)
