"""A scan finds its place on the map, and says along which direction it does not."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from contract.runlog.matched_scans import AGREES, NEW, THROUGH, points_of
from tests.vehicle_agent.localization.scan_map.places import (
    CORRIDOR,
    MOUNT,
    SQUARE,
    TILE_M,
    VOXEL_M,
    a_map,
    a_scan,
)
from vehicle_agent.localization.scan_map.localizer import ScanLocalizer, ScanPrior
from vehicle_agent.signals.point_cloud import point_cloud

SURE = np.diag([0.05**2, 0.05**2, 0.01**2])
SQUARE_TILES, CORRIDOR_TILES, FIELD_TILES = a_map(SQUARE), a_map(CORRIDOR), a_map(())


def a_localizer(tiles: dict = SQUARE_TILES) -> ScanLocalizer:
    return ScanLocalizer(lambda ix, iy: tiles.get((ix, iy)), TILE_M, VOXEL_M, MOUNT)


def off_m(pose: Pose2, true: Pose2) -> float:
    return math.hypot(pose.x_m - true.x_m, pose.y_m - true.y_m)


@settings(deadline=None, max_examples=12)
@given(
    st.floats(-6.0, 6.0), st.floats(-3.0, 3.0), st.floats(-3.1, 3.1), st.floats(-0.4, 0.4),
    st.floats(-0.4, 0.4), st.floats(-0.04, 0.04), st.integers(0, 99),
)  # fmt: skip
def test_a_scan_is_found_near_its_prior(
    x: float, y: float, yaw: float, dx: float, dy: float, turn: float, seed: int
) -> None:
    true = Pose2(x, y, yaw)
    prior = ScanPrior(Pose2(x + dx, y + dy, yaw + turn), SURE, 0.0, 0.0)
    found = a_localizer().step(a_scan(SQUARE, true, seed), prior)
    assert found is not None
    assert off_m(found.pose_map, true) < 0.06
    assert abs(math.remainder(found.pose_map.yaw_rad - yaw, math.tau)) < 0.006
    assert found.agreement > 0.8


def test_what_is_stated_holds_and_a_corridor_is_not_known_along_its_walls() -> None:
    true = Pose2(0.0, 1.0, 0.2)
    errors = []
    for seed in range(12):
        found = a_localizer().step(a_scan(SQUARE, true, seed), ScanPrior(true, SURE, 0.0, 0.0))
        assert found is not None
        error = np.array([found.pose_map.x_m - true.x_m, found.pose_map.y_m - true.y_m])
        errors.append(float(error @ np.linalg.inv(found.covariance[:2, :2]) @ error))
    assert np.mean(errors) < 6.0
    along = a_localizer(CORRIDOR_TILES).step(a_scan(CORRIDOR, true, 1), ScanPrior(true, SURE, 0.0, 0.0))
    assert along is not None
    assert math.sqrt(along.covariance[0, 0]) > 1.0
    assert math.sqrt(along.covariance[1, 1]) < 0.1


def test_an_open_field_a_blind_scan_and_a_place_without_a_map_say_nothing() -> None:
    true = Pose2(0.0, 0.0, 0.0)
    assert a_localizer(FIELD_TILES).step(a_scan((), true, 1), ScanPrior(true, SURE, 0.0, 0.0)) is None
    blind = point_cloud(0, np.full((500, 3), np.nan))
    assert a_localizer().step(blind, ScanPrior(true, SURE, 0.0, 0.0)) is None
    away = Pose2(900.0, 900.0, 0.0)
    assert a_localizer().step(a_scan(SQUARE, true, 1), ScanPrior(away, SURE, 0.0, 0.0)) is None


def test_once_a_second_a_scan_is_kept_for_the_run_log_with_what_its_points_say() -> None:
    true, localizer = Pose2(0.0, 1.0, 0.2), a_localizer()
    assert localizer.matched.take() is None
    scan = a_scan(SQUARE, true, 1)
    # Something new, 4 m away where the map has nothing above the road.
    thing = np.random.default_rng(2).uniform([3.5, -0.5, -1.5], [4.5, 0.5, -0.5], (200, 3))
    points = np.vstack((scan.points_sensor, thing))
    given = []
    for stamp_ns in (0, 400_000_000, 999_000_000, 1_000_000_000):
        localizer.step(point_cloud(stamp_ns, points), ScanPrior(true, SURE, 0.0, 0.0))
        given.append(localizer.matched.take())
        assert localizer.matched.take() is None
    first, last = given[0], given[-1]
    assert given[1:3] == [None, None]
    assert first is not None
    assert last is not None
    found, kinds = points_of(first)
    assert (kinds == AGREES).mean() > 0.8
    assert (kinds == NEW).sum() >= 1
    x_m = 4.0 + MOUNT[0, 3]
    is_thing = np.hypot(*(found - [x_m * math.cos(0.2), 1.0 + x_m * math.sin(0.2)]).T) < 0.6
    assert (kinds[is_thing] == NEW).mean() > 0.5


def test_from_a_wrong_place_beams_end_beyond_walls_of_the_map() -> None:
    true = Pose2(0.0, 1.0, 0.2)
    localizer = a_localizer()
    localizer.step(a_scan(SQUARE, true, 1), ScanPrior(Pose2(4.0, 5.0, 1.0), SURE, 0.0, 0.0))
    matched = localizer.matched.take()
    assert matched is not None
    _, kinds = points_of(matched)
    assert (kinds == THROUGH).sum() > 0
    assert (kinds == AGREES).mean() < 0.8


def test_a_wrong_place_agrees_less() -> None:
    true = Pose2(0.0, 1.0, 0.2)
    wrong = ScanPrior(Pose2(3.0, 4.0, 0.5), SURE, 0.0, 0.0)
    found = a_localizer().step(a_scan(SQUARE, true, 2), wrong)
    assert found is not None
    assert found.agreement < 0.6


@pytest.mark.parametrize(("dx", "dy", "turn"), [(6.0, -3.0, 0.3), (-5.0, 5.0, -0.25), (0.5, 8.0, 0.0)])
def test_a_lost_vehicle_is_searched_and_found(dx: float, dy: float, turn: float) -> None:
    true = Pose2(0.0, 1.0, 0.2)
    prior = ScanPrior(Pose2(dx, 1.0 + dy, 0.2 + turn), SURE, 0.0, 0.0, is_lost=True)
    found = a_localizer().step(a_scan(SQUARE, true, 3), prior)
    assert found is not None
    assert found.is_searched
    assert off_m(found.pose_map, true) < 0.1


# A truck and containers that are new, close to the vehicle and large.
NEW_THINGS = (
    ((4.0, 4.0, 0.0), (8.0, 0.0, 0.0), (0.0, 0.0, 4.0)),
    ((-9.0, -3.0, 0.0), (6.0, 0.5, 0.0), (0.0, 0.0, 3.0)),
    ((10.0, -3.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 3.0)),
)


def test_new_things_stand_before_walls_and_a_wrong_pose_has_walls_in_the_way() -> None:
    true, wrong = Pose2(0.0, 1.0, 0.2), Pose2(-12.0, 5.0, 0.5)
    changed = a_localizer().step(a_scan((*SQUARE, *NEW_THINGS), true, 4), ScanPrior(true, SURE, 0.0, 0.0))
    astray = a_localizer().step(a_scan(SQUARE, true, 4), ScanPrior(wrong, SURE, 0.0, 0.0))
    assert changed is not None
    assert astray is not None
    assert off_m(changed.pose_map, true) < 0.05
    assert changed.through < 0.1 * changed.agreement
    assert astray.through > astray.agreement


@pytest.mark.parametrize(("dx", "dy", "turn"), [(6.0, -3.0, 0.3), (-7.0, 2.0, -0.3)])
def test_a_lost_vehicle_is_found_in_a_changed_world(dx: float, dy: float, turn: float) -> None:
    true = Pose2(0.0, 1.0, 0.2)
    prior = ScanPrior(Pose2(dx, 1.0 + dy, 0.2 + turn), SURE, 0.0, 0.0, is_lost=True)
    found = a_localizer().step(a_scan((*SQUARE, *NEW_THINGS), true, 5), prior)
    assert found is not None
    assert found.is_searched
    assert off_m(found.pose_map, true) < 0.1


def test_a_sure_prior_is_not_drawn_to_a_wall_that_stands_elsewhere_today() -> None:
    """Two thirds of the end wall were moved by 35 cm, all else is as on the map."""
    end = (
        ((22.0, -14.0, 0.0), (0.0, 8.0, 0.0), (0.0, 0.0, 6.0)),
        ((22.35, -6.0, 0.0), (0.0, 17.0, 0.0), (0.0, 0.0, 6.0)),
    )
    moved = (*SQUARE[:2], *end, *SQUARE[3:])
    true = Pose2(0.0, 1.0, 0.2)
    found = a_localizer().step(a_scan(moved, true, 6), ScanPrior(true, SURE / 4.0, 0.0, 0.0))
    assert found is not None
    assert off_m(found.pose_map, true) < 0.06
