"""A lidar that was knocked is found by the road it sees; one that was not is left alone."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array
from contract.transforms import transform_of
from vehicle_agent.lidar.mount_watch import MountDrift, MountLimits, MountWatch, ground_plane
from vehicle_agent.lidar.rig import LidarRig, RigLidar, RigScan
from vehicle_agent.signals.point_cloud import point_cloud

SECOND_NS = 1_000_000_000
MOUNT = transform_of(0.0, 0.0, 0.3, np.array([2.0, 0.3, 2.0]))


def a_street(
    rng: np.random.Generator, pitch_rad: float = 0.0, roll_rad: float = 0.0, crest_1pm: float = 0.0
) -> Array:
    """(n, 3) in the vehicle's frame: road with its grain, two walls, a parked car, people.

    pitch, roll  of the vehicle on its springs; crest: curvature of the road along the way
    """
    away_m, towards = rng.uniform(2.0, 30.0, 1200), rng.uniform(-math.pi, math.pi, 1200)
    x, y = away_m * np.cos(towards), away_m * np.sin(towards)
    road = np.column_stack((x, y, -0.5 * crest_1pm * x**2 + rng.normal(0.0, 0.015, 1200)))
    walls = [
        np.column_stack((rng.uniform(-30, 30, 300), np.full(300, side), rng.uniform(0.0, 6.0, 300)))
        for side in (-8, 9)
    ]
    car = rng.uniform([4.0, 2.5, 0.2], [8.5, 4.3, 1.5], (200, 3))
    people = rng.uniform([3.0, -3.0, 0.0], [3.5, -2.5, 1.7], (60, 3))
    points = np.vstack((road, *walls, car, people))
    tilted: Array = points @ transform_of(roll_rad, pitch_rad, 0.0, np.zeros(3))[:3, :3].T
    return tilted


def knocked(roll_rad: float, pitch_rad: float, up_m: float) -> Array:
    """T_base_sensor of a lidar that was turned where it sits, about the vehicle's axes, and lifted."""
    moved = transform_of(roll_rad, pitch_rad, 0.0, np.zeros(3)) @ transform_of(0.0, 0.0, 0.3, np.zeros(3))
    moved[:3, 3] = MOUNT[:3, 3] + [0.0, 0.0, up_m]
    return moved


def seen(points_base: Array, T_base_sensor: Array) -> Array:
    """What the sensor gives: (n, 3) in its own frame."""
    given: Array = (points_base - T_base_sensor[:3, 3]) @ T_base_sensor[:3, :3]
    return given


def drift_after(
    true_mount: Array, turns: int, seed: int = 0, springs_rad: float = 0.008
) -> MountDrift | None:
    rng, watch = np.random.default_rng(seed), MountWatch()
    for turn in range(turns):
        street = a_street(
            rng, rng.normal(0.0, springs_rad), rng.normal(0.0, springs_rad), rng.uniform(-0.002, 0.002)
        )
        points = seen(street, true_mount) @ MOUNT[:3, :3].T + MOUNT[:3, 3]
        watch.add(turn * SECOND_NS, points)
    return watch.drift


@settings(max_examples=12)
@given(st.integers(0, 10_000))
def test_a_lidar_in_its_place_is_left_alone_on_springs_and_crests(seed: int) -> None:
    assert drift_after(MOUNT, 60, seed) is None


@settings(max_examples=15)
@given(st.floats(0.05, 0.13), st.floats(-math.pi, math.pi), st.floats(-0.05, 0.05), st.integers(0, 10_000))
def test_a_knock_is_found_with_its_size_and_direction(
    tilt_rad: float, towards: float, up_m: float, seed: int
) -> None:
    roll_rad, pitch_rad = tilt_rad * math.cos(towards), tilt_rad * math.sin(towards)
    drift = drift_after(knocked(roll_rad, pitch_rad, up_m), 40, seed)
    assert drift is not None
    assert drift.roll_rad == pytest.approx(roll_rad, abs=0.012)
    assert drift.pitch_rad == pytest.approx(pitch_rad, abs=0.012)


def test_a_mast_that_sank_is_found() -> None:
    drift = drift_after(knocked(0.0, 0.0, -0.3), 40)
    assert drift is not None
    assert drift.height_m == pytest.approx(-0.3, abs=0.02)


def test_a_place_without_a_road_in_sight_says_nothing() -> None:
    rng = np.random.default_rng(1)
    bushes = rng.uniform([-10.0, -10.0, 0.0], [10.0, 10.0, 2.0], (3000, 3))
    assert ground_plane(bushes, MountLimits()) is None
    assert ground_plane(np.zeros((0, 3)), MountLimits()) is None
    assert ground_plane(np.zeros((3000, 3)), MountLimits()) is None


def test_a_lidar_that_hangs_is_named_until_it_is_put_back_and_seen_by_all_the_while() -> None:
    """A ramp before a vehicle that stands looks alike: no vehicle loses a lidar by it."""
    rng, rig = np.random.default_rng(2), LidarRig([RigLidar("roof", MOUNT)])

    def last_after(true_mount: Array, begin: int, turns: int) -> RigScan:
        scan = None
        for turn in range(begin, begin + turns):
            points = seen(a_street(rng), true_mount)
            scan = rig.add("roof", point_cloud(turn * SECOND_NS, points, rng.uniform(0, 200, len(points))))
        assert scan is not None
        assert not scan.is_blind
        assert scan.missing == {}
        return scan

    assert last_after(MOUNT, 0, 60).drifts == {}
    drift = last_after(knocked(0.0, 0.15, -0.1), 60, 55).drifts["roof"]
    assert drift.pitch_rad == pytest.approx(0.15, abs=0.015)
    assert last_after(MOUNT, 115, 55).drifts == {}
