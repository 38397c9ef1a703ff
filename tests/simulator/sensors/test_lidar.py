import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from contract.roads.model import Building
from simulator.sensors.lidar import REFLECTIVITY, Lidar, LidarNoise
from simulator.sensors.ray_hits import GROUND, PERSON, VEHICLE, WALL, Array32
from simulator.sensors.walls import WallScene
from vehicle_agent.config import Body, LidarMount

HERE = Pose2(0.0, 0.0, 0.0)
NO_BOXES = np.zeros((0, 7))
NO_PEOPLE = np.zeros((0, 4))
EXACT = LidarNoise(range_std_m=0.0, dropout_ratio=0.0)


def a_lidar(*buildings: Building, noise: LidarNoise = EXACT) -> Lidar:
    return Lidar(LidarMount(), Body(), WallScene(buildings), noise)


def rng(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


def of_kind(scan: tuple[Array32, Array32], kind: int) -> Array32:
    points, intensities = scan
    return points[intensities == REFLECTIVITY[kind]]


def test_the_ground_lies_at_height_zero_and_begins_eight_and_a_half_metres_before_the_sensor() -> None:
    ground = of_kind(a_lidar().scan(HERE, NO_BOXES, NO_PEOPLE, rng()), GROUND)
    assert np.abs(ground[:, 2]).max() < 1e-4
    ranges = np.hypot(ground[:, 0] - 3.2, ground[:, 1])
    assert ranges.min() == pytest.approx(2.28 / math.tan(math.radians(15.0)), abs=0.01)


def test_a_wall_is_seen_at_its_distance_from_where_the_vehicle_stands() -> None:
    wall = Building(((20.0, -30.0), (20.0, 30.0), (22.0, 30.0), (22.0, -30.0)), 9.0)
    for pose in (HERE, Pose2(5.0, 1.0, 0.0), Pose2(5.0, 1.0, 0.4)):
        points = of_kind(a_lidar(wall).scan(pose, NO_BOXES, NO_PEOPLE, rng()), WALL)
        cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        x_map = pose.x_m + cos * points[:, 0] - sin * points[:, 1]
        assert len(points) > 1000
        assert np.abs(x_map - 20.0).max() < 1e-3


@settings(max_examples=40, deadline=None)
@given(st.floats(4.0, 30.0), st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_a_person_is_seen_where_the_person_stands(
    distance_m: float, bearing_rad: float, yaw_rad: float
) -> None:
    pose = Pose2(100.0, -50.0, yaw_rad)
    sensor_x = pose.x_m + 3.2 * math.cos(yaw_rad)
    sensor_y = pose.y_m + 3.2 * math.sin(yaw_rad)
    x = sensor_x + distance_m * math.cos(bearing_rad + yaw_rad)
    y = sensor_y + distance_m * math.sin(bearing_rad + yaw_rad)
    person = np.array([[x, y, 0.25, 1.7]])
    points = of_kind(a_lidar().scan(pose, NO_BOXES, person, rng()), PERSON)
    if abs(bearing_rad) < 2.3 or distance_m > 10.0:
        assert len(points) > 0
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    x_map = pose.x_m + cos * points[:, 0] - sin * points[:, 1]
    y_map = pose.y_m + sin * points[:, 0] + cos * points[:, 1]
    off_axis = np.hypot(x_map - x, y_map - y)
    # on the cylinder's side, or on the disc of its top
    assert (off_axis < 0.251).all()
    side = points[:, 2] < 1.699
    assert np.abs(off_axis[side] - 0.25).max(initial=0.0) < 2e-3


def test_a_vehicle_ahead_is_seen_at_its_rear_bumper() -> None:
    ahead = np.array([[10.0, 0.0, 0.0, 0.85, 3.5, 0.815, 2.28]])
    points = of_kind(a_lidar().scan(HERE, ahead, NO_PEOPLE, rng()), VEHICLE)
    points = points[points[:, 0] > 4.0]
    assert len(points) > 300
    assert points[:, 0].min() == pytest.approx(9.15, abs=1e-3)
    assert np.abs(points[:, 1]).max() < 0.8151


def test_what_stands_behind_a_wall_is_hidden() -> None:
    wall = Building(((8.0, -30.0), (8.0, 30.0), (9.0, 30.0), (9.0, -30.0)), 9.0)
    person = np.array([[12.0, 0.0, 0.25, 1.7]])
    assert len(of_kind(a_lidar(wall).scan(HERE, NO_BOXES, person, rng()), PERSON)) == 0
    assert len(of_kind(a_lidar().scan(HERE, NO_BOXES, person, rng()), PERSON)) > 0


def test_its_own_vehicle_is_seen_only_inside_its_own_outline() -> None:
    points = of_kind(a_lidar().scan(HERE, NO_BOXES, NO_PEOPLE, rng()), VEHICLE)
    assert len(points) > 0
    assert points[:, 0].min() > -0.86
    assert points[:, 0].max() < 3.51
    assert np.abs(points[:, 1]).max() < 0.82


def test_one_seed_gives_one_scan_and_another_seed_another() -> None:
    lidar = a_lidar(noise=LidarNoise())
    person = np.array([[12.0, 0.0, 0.25, 1.7]])
    first, again = (lidar.scan(HERE, NO_BOXES, person, rng(7)) for _ in range(2))
    assert np.array_equal(first[0], again[0])
    assert np.array_equal(first[1], again[1])
    assert not np.array_equal(first[0], lidar.scan(HERE, NO_BOXES, person, rng(8))[0])


def test_noise_has_the_spread_and_dropouts_have_the_share_that_were_asked_for() -> None:
    exact = a_lidar().scan(HERE, NO_BOXES, NO_PEOPLE, rng())[0]
    noisy = a_lidar(noise=LidarNoise(0.02, 0.0)).scan(HERE, NO_BOXES, NO_PEOPLE, rng())[0]
    along = np.linalg.norm(noisy - [3.2, 0, 2.28], axis=1) - np.linalg.norm(exact - [3.2, 0, 2.28], axis=1)
    assert along.std() == pytest.approx(0.02, rel=0.05)
    thinned = a_lidar(noise=LidarNoise(0.0, 0.1)).scan(HERE, NO_BOXES, NO_PEOPLE, rng())[0]
    assert len(thinned) / len(exact) == pytest.approx(0.9, abs=0.01)
