"""Objects of one scan: who is a person, and what only looks like one."""

import math

import numpy as np
import pytest

from tests.vehicle_agent.perception.points.bodies import GRID_ARGUMENTS, person, pillar, road, scan, sides
from vehicle_agent.perception.points.cells import point_heights
from vehicle_agent.perception.points.clusters import ClusterParams, objects_of_points
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE
from vehicle_agent.signals.objects import SeenObjects

GRID = PointGrid(*GRID_ARGUMENTS)


def objects_in(*parts: np.ndarray) -> SeenObjects:
    points = scan(road(), *parts)
    return objects_of_points(points, point_heights(points, GRID), 7, GRID, ClusterParams())


@pytest.mark.parametrize("place", [(6.0, 1.0), (12.0, -4.0), (18.0, 5.0), (-4.0, 3.0)])
def test_a_person_is_a_pedestrian_where_he_stands(place: tuple[float, float]) -> None:
    seen = objects_in(person(*place))
    assert seen.kinds.tolist() == [PEDESTRIAN]
    assert seen.poses_base[0, :2] == pytest.approx(place, abs=0.15)
    assert seen.stamp_ns == 7
    assert np.isnan(seen.velocities_base_mps).all()


@pytest.mark.parametrize("apart_m", [0.6, 0.75, 1.2])
@pytest.mark.parametrize("is_behind", [False, True])
def test_people_close_together_are_told_apart(apart_m: float, is_behind: bool) -> None:
    other = (9.0 + apart_m, 1.4) if is_behind else (9.0, 1.0 + apart_m)
    seen = objects_in(person(9.0, 1.0), person(*other))
    assert seen.kinds.tolist() == [PEDESTRIAN, PEDESTRIAN]


def test_three_people_side_by_side_are_three() -> None:
    seen = objects_in(person(9.0, -0.65), person(9.0, 0.0), person(9.0, 0.65))
    assert seen.kinds.tolist() == [PEDESTRIAN] * 3


@pytest.mark.parametrize(
    "thing",
    [
        pillar(9.0, 2.0, 0.15, 0.05, 2.7),
        pillar(9.0, 2.0, 0.06, 0.05, 0.9),
        pillar(9.0, 2.0, 0.05, 0.05, 2.7),
        sides(9.0, 3.0, 0.1, 6.0, 0.4, 0.05, 2.3),
        sides(9.0, 3.0, 0.0, 2.0, 0.7, 0.05, 1.0),
        sides(8.0, 2.0, 0.2, 0.7, 0.5, 0.02, 0.6),
    ],
    ids=["trunk", "bollard", "post", "wall", "hedge", "suitcase"],
)
def test_street_furniture_is_no_pedestrian(thing: np.ndarray) -> None:
    seen = objects_in(thing)
    assert PEDESTRIAN not in seen.kinds.tolist()


def test_a_person_beside_a_trunk_stays_a_pedestrian() -> None:
    seen = objects_in(pillar(9.0, 2.0, 0.15, 0.05, 2.7), person(9.0, 2.65))
    assert sorted(seen.kinds.tolist()) == [PEDESTRIAN, OTHER]


def test_a_person_behind_a_hood_stays_a_pedestrian() -> None:
    assert objects_in(person(9.0, 2.0, low_m=0.95)).kinds.tolist() == [PEDESTRIAN]


@pytest.mark.parametrize("yaw", [0.0, 0.5, 1.2, -0.9])
def test_a_car_has_its_direction_and_size(yaw: float) -> None:
    seen = objects_in(sides(11.0, 4.0, yaw, 4.4, 1.8, 0.25, 1.45))
    assert seen.kinds.tolist() == [VEHICLE]
    assert math.remainder(seen.poses_base[0, 2] - yaw, math.pi) == pytest.approx(0.0, abs=0.1)
    assert seen.sizes_m[0, :2] == pytest.approx((4.4, 1.8), abs=0.3)
    assert seen.poses_base[0, :2] == pytest.approx((11.0, 4.0), abs=0.25)


def test_the_rear_of_a_car_lies_across_its_direction() -> None:
    seen = objects_in(sides(12.0, 0.0, 0.0, 0.3, 1.8, 0.25, 1.45))
    assert seen.kinds.tolist() == [VEHICLE]
    assert abs(math.remainder(seen.poses_base[0, 2], math.pi)) < 0.1


def test_a_cyclist_from_the_side_is_a_cyclist() -> None:
    bicycle = sides(9.0, 3.0, 0.0, 1.7, 0.1, 0.05, 0.9)
    assert objects_in(bicycle, person(8.9, 3.0, 1.75)).kinds.tolist() == [CYCLIST]


def test_the_result_does_not_depend_on_the_order_of_points() -> None:
    points = scan(road(), person(9.0, 1.0), person(9.0, 1.7), sides(11.0, 5.0, 0.4, 4.4, 1.8, 0.25, 1.45))
    shuffled = np.random.default_rng(3).permutation(points)
    one, other = (
        objects_of_points(p, point_heights(p, GRID), 7, GRID, ClusterParams()) for p in (points, shuffled)
    )
    assert sorted(one.kinds.tolist()) == sorted(other.kinds.tolist())
    assert np.sort(one.poses_base[:, 0]) == pytest.approx(np.sort(other.poses_base[:, 0]), abs=0.02)


def test_an_empty_scan_has_no_objects() -> None:
    nothing = np.empty((0, 3), np.float32)
    seen = objects_of_points(nothing, point_heights(nothing, GRID), 7, GRID, ClusterParams())
    assert len(seen.kinds) == 0
