import math

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, Tracks, View
from vehicle_agent.world.view import VisibilityParams, points_on_walls

NOTHING = np.empty((0, 2))
NO_WALLS = np.empty((0, 4))
SIGHT = VisibilityParams(0.0)


def range_towards(view: View, bearing_rad: float) -> float:
    k = math.floor((bearing_rad + math.pi) / (2.0 * math.pi) * len(view.ranges_m)) % len(view.ranges_m)
    return float(view.ranges_m[k])


def test_a_wall_of_the_map_ends_the_sight_in_the_vehicles_own_frame() -> None:
    wall = np.array([[10.0, -5.0, 10.0, 5.0]])
    view = SIGHT.view(Pose2(0.0, 0.0, math.pi / 2), NOTHING, some_tracks(), wall)
    assert range_towards(view, -math.pi / 2) == pytest.approx(10.0, abs=0.01)
    assert range_towards(view, 0.0) == SIGHT.range_m


def test_parked_cars_hide_and_people_and_driving_cars_do_not() -> None:
    tracks = some_tracks(
        (VEHICLE, 10.0, 0.0, 0.0, 0.0), (PEDESTRIAN, 0.0, 5.0, 0.0, 0.0), (VEHICLE, 0.0, -8.0, 5.0, 0.0)
    )
    view = SIGHT.view(Pose2(0.0, 0.0, 0.0), NOTHING, tracks, NO_WALLS)
    assert range_towards(view, 0.0) == pytest.approx(7.75, abs=0.01)
    assert range_towards(view, math.pi / 2) == SIGHT.range_m
    assert range_towards(view, -math.pi / 2) == SIGHT.range_m


@pytest.mark.parametrize("number", range(8))
def test_a_parked_car_hides_as_much_as_it_covers_from_wherever_it_is_seen(number: int) -> None:
    around_rad = number * math.pi / 4 + 0.1
    x_m, y_m = 20.0 + 7.0 * math.cos(around_rad), -7.0 + 7.0 * math.sin(around_rad)
    one = np.array([1])
    car = Tracks(
        0, one, VEHICLE * one, np.array([[20.0, -7.0, 0.6]]), np.zeros((1, 2)), np.array([[4.5, 1.8]])
    )
    outline = shapely.affinity.translate(
        shapely.affinity.rotate(shapely.box(-2.25, -0.9, 2.25, 0.9), 0.6, (0, 0), use_radians=True),
        20.0,
        -7.0,
    )
    view = SIGHT.view(Pose2(x_m, y_m, 0.0), NOTHING, car, NO_WALLS)
    for k, range_m in enumerate(view.ranges_m):
        bearing_rad = -math.pi + (k + 0.5) * 2.0 * math.pi / len(view.ranges_m)
        far = (x_m + SIGHT.range_m * math.cos(bearing_rad), y_m + SIGHT.range_m * math.sin(bearing_rad))
        met = outline.intersection(shapely.LineString([(x_m, y_m), far]))
        expected_m = SIGHT.range_m if met.is_empty else met.distance(shapely.Point(x_m, y_m))
        assert range_m == pytest.approx(expected_m, abs=1e-6)


@pytest.mark.parametrize(("away_m", "beside_rad"), [(0.5, 0.7), (3.0, 0.3)])
def test_an_obstacle_cell_hides_what_is_behind_it(away_m: float, beside_rad: float) -> None:
    view = SIGHT.view(Pose2(0.0, 0.0, 0.0), np.array([[away_m, 0.0]]), some_tracks(), NO_WALLS)
    assert range_towards(view, 0.0) == pytest.approx(away_m)
    assert range_towards(view, beside_rad) == SIGHT.range_m


def test_a_cell_in_the_sensors_own_place_hides_nothing() -> None:
    view = SIGHT.view(Pose2(2.0, 1.0, 0.0), np.array([[2.0, 1.0]]), some_tracks(), NO_WALLS)
    assert (view.ranges_m == SIGHT.range_m).all()


def test_walls_become_cells_no_farther_apart_than_the_step() -> None:
    cells = points_on_walls(np.array([[0.0, 0.0, 10.0, 0.0]]), Pose2(0.0, 3.0, 0.0), 40.0, 0.4)
    steps = np.diff(np.sort(cells[:, 0]))
    assert steps.max() <= 0.4 + 1e-9
    assert cells[:, 0].min() == 0.0
    assert cells[:, 0].max() == 10.0


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_the_sight_ends_where_a_ray_first_meets_a_wall(seed: int) -> None:
    random = np.random.default_rng(seed)
    walls = random.uniform(-30.0, 30.0, (4, 4))
    x, y, yaw = random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0), random.uniform(-math.pi, math.pi)
    view = SIGHT.view(Pose2(x, y, yaw), NOTHING, some_tracks(), walls)
    here = shapely.Point(x, y)
    lines = [shapely.LineString([(x0, y0), (x1, y1)]) for x0, y0, x1, y1 in walls]
    step = 2.0 * math.pi / len(view.ranges_m)
    for k in range(0, len(view.ranges_m), 7):
        angle = yaw - math.pi + (k + 0.5) * step
        end = (x + SIGHT.range_m * math.cos(angle), y + SIGHT.range_m * math.sin(angle))
        ray = shapely.LineString([(x, y), end])
        meets = [here.distance(line.intersection(ray)) for line in lines if line.intersects(ray)]
        assert view.ranges_m[k] == pytest.approx(min([SIGHT.range_m, *meets]), abs=1e-6)
