"""A short simulated drive becomes a map; what has moved is not on it."""

import numpy as np
import pytest

from benchmarks.odometry.simulated import Loop, SimulatedDrive
from contract.roads.model import Origin
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud
from workshop.cloud_mapping.gnss_fixes import Fixes
from workshop.cloud_mapping.mapping import CloudMap, CloudMappingParams, NoProgress, TooFewScans, map_scans
from workshop.cloud_mapping.residuals import trajectory_error_m
from workshop.cloud_mapping.surfaces import SurfaceParams, surfels_of


@pytest.fixture(scope="module")
def drive() -> tuple[list[PointCloud], np.ndarray]:
    simulated = SimulatedDrive(5, Loop(length_m=24.0, width_m=22.0, radius_m=8.0, speed_mps=5.0))
    return list(simulated.clouds()), simulated.truth()


@pytest.fixture(scope="module")
def mapped(drive: tuple[list[PointCloud], np.ndarray]) -> CloudMap:
    clouds, _ = drive
    return map_scans(clouds, len(clouds), None, CloudMappingParams(), NoProgress())


def test_the_drive_is_found_and_its_loop_is_closed(
    mapped: CloudMap, drive: tuple[list[PointCloud], np.ndarray]
) -> None:
    _, truth = drive
    assert trajectory_error_m(mapped.poses[:, :3, 3], truth[:, :3, 3]) < 0.1
    assert mapped.residuals.loops_closed > 0
    assert mapped.notes == ()
    # Walls are where they are: most elements are surfaces, and the ground is level.
    level = np.abs(mapped.surfels.normals[:, 2]) > 0.98
    assert level.sum() > 300


def test_equal_scans_give_equal_maps(mapped: CloudMap, drive: tuple[list[PointCloud], np.ndarray]) -> None:
    clouds, _ = drive
    again = map_scans(clouds, len(clouds), None, CloudMappingParams(), NoProgress())
    assert np.array_equal(again.surfels.means, mapped.surfels.means)
    assert np.array_equal(again.poses, mapped.poses)


def test_fixes_put_the_map_on_the_campus(drive: tuple[list[PointCloud], np.ndarray]) -> None:
    clouds, truth = drive
    rng = np.random.default_rng(1)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    true = truth[:, :3, 3] @ turn.T + np.array([120.0, -40.0, 3.0])
    stamps = np.array([cloud.stamp_ns for cloud in clouds], dtype=np.int64)
    fixes = Fixes(
        Origin(31.0, 121.0), stamps, true + rng.normal(0.0, 0.02, true.shape), np.full(true.shape, 0.02), 0
    )
    found = map_scans(clouds, len(clouds), fixes, CloudMappingParams(), NoProgress())
    assert found.origin == Origin(31.0, 121.0)
    assert np.sqrt(((found.poses[:, :3, 3] - true) ** 2).sum(axis=1).mean()) < 0.15


def test_scans_that_show_nothing_make_no_map() -> None:
    blind = [point_cloud(100_000_000 * n, np.full((400, 3), np.nan)) for n in range(20)]
    with pytest.raises(TooFewScans, match="20 scans, of which 19 show too little"):
        map_scans(blind, len(blind), None, CloudMappingParams(), NoProgress())


def test_what_beams_went_through_is_not_on_the_map() -> None:
    rng = np.random.default_rng(2)
    wall = np.column_stack(
        (np.full(3_000, 12.0), rng.uniform(-4.0, 4.0, 3_000), rng.uniform(-1.0, 2.0, 3_000))
    )
    car = np.column_stack((np.full(200, 6.1), rng.uniform(-1.0, 1.0, 200), rng.uniform(-0.8, 0.6, 200)))
    behind_car = (np.abs(wall[:, 1]) < 2.0) & (wall[:, 2] > -1.6) & (wall[:, 2] < 1.2)
    clouds = [np.concatenate((wall[~behind_car], car)) if n < 3 else wall for n in range(20)]
    poses = np.tile(np.eye(4), (20, 1, 1))
    surfels, removed = surfels_of(
        [cloud.astype(np.float32) for cloud in clouds], poses, SurfaceParams(), lambda n: None
    )
    assert removed > 5
    assert (np.abs(surfels.means[:, 0] - 12.0) < 0.2).sum() > 60
    # Corners that hardly a beam meets may stay.
    assert (np.abs(surfels.means[:, 0] - 6.1) < 0.3).sum() <= 2
