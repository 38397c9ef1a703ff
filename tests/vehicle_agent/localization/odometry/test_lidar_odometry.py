"""The odometry follows a known drive, is deterministic, and survives scans that say nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.odometry.simulated import Loop, SimulatedDrive
from vehicle_agent.localization.odometry.lidar_odometry import LidarOdometry
from vehicle_agent.localization.odometry.motion import deskewed, exponential, inverted, logarithm
from vehicle_agent.localization.odometry.registration import align
from vehicle_agent.localization.odometry.voxel_map import add_points, empty_map, first_of_voxels, remove_far
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud

TWISTS = st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6).map(np.array)


@pytest.fixture(scope="module")
def drive() -> tuple[list[PointCloud], np.ndarray]:
    """A short loop: 12 s, with a right-angled bend at each corner."""
    simulated = SimulatedDrive(5, Loop(length_m=24.0, width_m=22.0, radius_m=8.0, speed_mps=5.0))
    return list(simulated.clouds()), simulated.truth()


class PausedDrive(SimulatedDrive):
    """It stands for two seconds, drives off at 1 m/s2, and stands again where the loop ends."""

    def __init__(self) -> None:
        super().__init__(5, Loop(length_m=24.0, width_m=22.0, radius_m=8.0, speed_mps=5.0))
        self._end_ns = 100_000_000 * (self.scans - 1)
        self.scans += 40

    def _poses(self, times_ns: np.ndarray) -> np.ndarray:
        return super()._poses(np.clip(times_ns - 2_000_000_000, 0, self._end_ns))


def test_a_sensor_that_stands_keeps_its_pose_and_loses_nothing_when_it_drives_off() -> None:
    drive = PausedDrive()
    poses, truth = followed(list(drive.clouds())), drive.truth()
    assert np.array_equal(poses[:20], np.tile(np.eye(4), (20, 1, 1)))
    assert np.array_equal(poses[-12:], np.tile(poses[-1], (12, 1, 1)))
    apart = np.linalg.norm(poses[:, :3, 3] - truth[:, :3, 3], axis=1)
    assert apart[20:30].max() < 0.04, "it drives off within two scans"
    assert apart.max() < 0.35
    assert apart[-1] < 0.1


def followed(clouds: list[PointCloud]) -> np.ndarray:
    odometry = LidarOdometry()
    return np.array([odometry.step(cloud).pose for cloud in clouds])


@given(TWISTS)
def test_a_motion_and_its_twist_are_one(twist: np.ndarray) -> None:
    motion = exponential(twist)
    assert motion[:3, :3] @ motion[:3, :3].T == pytest.approx(np.eye(3), abs=1e-9)
    assert inverted(motion) @ motion == pytest.approx(np.eye(4), abs=1e-9)
    if np.linalg.norm(twist[3:]) < 3.0:
        assert logarithm(motion) == pytest.approx(twist, abs=1e-6)


@given(TWISTS)
def test_points_are_put_where_they_were_seen_from_at_the_stamp(twist: np.ndarray) -> None:
    slow = 0.2 * twist
    points = np.array([[10.0, 2.0, -1.0], [-4.0, 7.0, 0.5]])
    straight = deskewed(points, np.array([0.1, 0.0]), slow)
    expected = exponential(0.1 * slow) @ np.append(points[0], 1.0)
    assert straight[0] == pytest.approx(expected[:3], abs=1e-3)
    assert straight[1] == pytest.approx(points[1], abs=1e-12)


def test_a_loop_is_followed_and_closes(drive: tuple[list[PointCloud], np.ndarray]) -> None:
    clouds, truth = drive
    poses = followed(clouds)
    apart = np.linalg.norm(poses[:, :3, 3] - truth[:, :3, 3], axis=1)
    way_m = np.linalg.norm(np.diff(truth[:, :3, 3], axis=0), axis=1).sum()
    assert way_m > 40.0
    assert apart.max() < 0.35
    assert apart[-1] < 0.1
    assert np.array_equal(poses, followed(clouds))


def test_without_times_a_bent_scan_is_worse_but_followed(drive: tuple[list[PointCloud], np.ndarray]) -> None:
    clouds, truth = drive
    timeless = [point_cloud(cloud.stamp_ns, cloud.points_sensor) for cloud in clouds[:60]]
    apart = np.linalg.norm(followed(timeless)[:, :3, 3] - truth[:60, :3, 3], axis=1)
    assert apart.max() < 1.0


def test_scans_that_say_nothing_keep_the_motion(drive: tuple[list[PointCloud], np.ndarray]) -> None:
    clouds, truth = drive
    broken = list(clouds[:50])
    nothing = np.zeros((0, 3))
    holes = np.full((500, 3), np.nan)
    near = np.full((500, 3), 0.1)
    for number, points in ((20, nothing), (25, holes), (30, near)):
        broken[number] = point_cloud(clouds[number].stamp_ns, points)
    poses = followed(broken)
    assert np.isfinite(poses).all()
    assert np.linalg.norm(poses[-1, :3, 3] - truth[49, :3, 3]) < 0.3


def test_stamps_that_stand_still_or_jump_do_not_throw_the_pose(
    drive: tuple[list[PointCloud], np.ndarray],
) -> None:
    clouds, truth = drive
    stamps = [cloud.stamp_ns for cloud in clouds[:40]]
    stamps[20], stamps[30] = stamps[19], stamps[30] + 10**15
    odd = [
        PointCloud(
            stamp, *(getattr(cloud, name) for name in ("points_sensor", "intensities", "rings", "offsets_ns"))
        )
        for stamp, cloud in zip(stamps, clouds, strict=False)
    ]
    assert np.linalg.norm(followed(odd)[-1, :3, 3] - truth[39, :3, 3]) < 0.3


def test_alignment_finds_a_displaced_room_and_leaves_open_directions_alone() -> None:
    rng = np.random.default_rng(2)
    floor = np.column_stack((rng.uniform(-6.0, 6.0, (6_000, 2)), np.zeros(6_000)))
    wall = np.column_stack((rng.uniform(-6.0, 6.0, 3_000), np.full(3_000, 6.0), rng.uniform(0.0, 3.0, 3_000)))
    end = wall[:, [1, 0, 2]]
    voxels = empty_map(1.0)
    add_points(voxels, np.vstack((floor, wall, end)))
    pose = exponential(np.array([0.2, -0.15, 0.1, 0.01, -0.02, 0.03]))
    seen = (np.vstack((floor, wall, end))[::9] - pose[:3, 3]) @ pose[:3, :3]
    found, _, partners = align(seen, voxels, np.eye(4), 1.0, 0.3, 50, 1e-6)
    assert partners > 1_000
    assert found == pytest.approx(pose, abs=0.01)


def test_far_voxels_are_forgotten_and_near_ones_kept() -> None:
    voxels = empty_map(1.0, capacity=64)
    rng = np.random.default_rng(3)
    places = rng.uniform(-80.0, 80.0, (5_000, 3))
    add_points(voxels, places)
    assert voxels.used == len(first_of_voxels(places, 1.0))
    remove_far(voxels, np.zeros(3), 40.0)
    near = places[np.linalg.norm(places, axis=1) < 38.0]
    kept = voxels.surfaces[voxels.keys != -1, :3]
    assert np.linalg.norm(kept, axis=1).max() <= 40.0
    assert len(first_of_voxels(near, 1.0)) <= voxels.used < 5_000
    before = voxels.used
    add_points(voxels, near)
    assert voxels.used == before
