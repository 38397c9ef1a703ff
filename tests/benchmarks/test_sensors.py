import numpy as np
import pytest

from benchmarks.sensors.drive import Drive, others_around, way_over
from simulator.sensors.scene.ground import Ground
from tests.simulator.sensors.scene.campus import a_street


def test_drive_stays_on_the_road_at_its_speed() -> None:
    road_map = a_street()
    ground = Ground(road_map, 1)
    drive = Drive(way_over(road_map, 60.0, np.random.default_rng(1)), ground, 4.0, 2.6)
    poses = drive.poses(np.arange(0, 10_000_000_000, 100_000_000))
    assert np.linalg.norm(np.diff(poses[:, :2, 3], axis=0), axis=1) == pytest.approx(0.4, abs=0.01)
    assert ground.inside_at(poses[:, 0, 3], poses[:, 1, 3]).min() > 1.0
    assert poses[:, :3, :3] @ poses[:, :3, :3].transpose(0, 2, 1) == pytest.approx(
        np.tile(np.eye(3), (len(poses), 1, 1)), abs=1e-9
    )


def test_map_without_so_long_a_way_is_refused() -> None:
    with pytest.raises(SystemExit, match="5000 m"):
        way_over(a_street(), 5000.0, np.random.default_rng(1))


def test_others_stay_around_the_vehicle() -> None:
    bodies = others_around(np.array([100.0, 50.0, 0.3]), 7.0, 20, 6)
    assert np.count_nonzero(bodies.people) == 20
    apart = np.hypot(bodies.poses_map[:, 0] - 100.0, bodies.poses_map[:, 1] - 50.0)
    assert 3.0 < apart.min() < apart.max() < 50.0
