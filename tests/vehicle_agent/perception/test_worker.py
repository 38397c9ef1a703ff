"""The worker of a vehicle that drives: what stands beside its way stands still in its tracks."""

import msgspec
import numpy as np
import pytest

from tests.vehicle_agent.perception.test_height_map import a_scan
from vehicle_agent.config import Profile
from vehicle_agent.perception.worker import PerceptionWorker
from vehicle_agent.signals import PEDESTRIAN, ObstaclePercept, Percept, SignPercept, TrackPercept
from vehicle_agent.signals.objects import EgoMotion
from vehicle_agent.stacks.choice import build_perception_worker

SNOW_LION = Profile(stack="snow_lion")
OWN = msgspec.structs.replace(SNOW_LION, perception="own")
TICK_NS, SCAN_TICKS = 20_000_000, 5
SPEED_MPS = 3.0
PERSON = (0.5, 1.7)


def drive(worker: PerceptionWorker, scans: int) -> list[tuple[Percept, ...]]:
    """Past a person who stands 20 m ahead and 3 m aside; the motions come with the ticks, as on a vehicle."""
    found = []
    for tick in range(scans * SCAN_TICKS + 1):
        now_ns = 1_000_000_000 + tick * TICK_NS
        worker.take(EgoMotion(now_ns, SPEED_MPS, 0.0))
        if tick % SCAN_TICKS == 0:
            points = a_scan([(20.0 - SPEED_MPS * tick * TICK_NS * 1e-9, 3.0, *PERSON)])
            # Intensities, and each point's time from the stamp.
            rows = np.column_stack((points, np.zeros((len(points), 2), np.float32)))
            found.append(worker.percepts(rows, now_ns))
    return found


def test_who_stands_beside_the_way_has_no_speed_though_the_vehicle_drives() -> None:
    found = drive(build_perception_worker(OWN), 12)
    cells, tracks = found[-1]
    assert isinstance(cells, ObstaclePercept)
    assert isinstance(tracks, TrackPercept)
    assert tracks.kinds.tolist() == [PEDESTRIAN]
    assert tracks.velocities_base_mps[0] == pytest.approx((0.0, 0.0), abs=0.25)
    assert tracks.poses_base[0, 0] == pytest.approx(20.0 - SPEED_MPS * 1.2, abs=0.3)


def test_a_vehicle_with_a_tracker_gets_cells_alone() -> None:
    for profile in (SNOW_LION, Profile()):
        found = drive(build_perception_worker(profile), 2)
        assert [type(percept) for percept in found[-1]] == [ObstaclePercept], profile.stack


def test_a_gem_that_tracks_by_itself_reads_signs_in_the_same_scans() -> None:
    worker = build_perception_worker(Profile(perception="own"))
    found = drive(worker, 2)
    assert [type(percept) for percept in found[-1]] == [ObstaclePercept, TrackPercept]
    rows = np.zeros((4, 5), np.float32)
    assert [type(percept) for percept in worker.signs(rows, 1_300_000_000)] == [SignPercept]


def test_points_for_people_who_look_are_where_the_obstacles_are() -> None:
    """The scan turns while the vehicle drives: its points are straightened as those of the obstacles."""
    for profile in (SNOW_LION, OWN):
        worker = build_perception_worker(profile)
        worker.take(EgoMotion(1_000_000_000, SPEED_MPS, 0.0))
        # Measured 0.1 s before the stamp, when the person was 0.3 m farther.
        points = a_scan([(8.3, 3.0, *PERSON)])
        times_s = np.full((len(points), 2), [0.0, -0.1], np.float32)
        rows = np.column_stack((points, times_s))
        scan = worker.thinned(rows, 1_000_000_000)
        assert scan is not None
        shown = 0.01 * np.frombuffer(scan.points_cm, "<i2").reshape(-1, 3)
        person = shown[np.abs(shown[:, 1] - 3.0) < 0.5]
        assert person[:, 0].mean() == pytest.approx(8.3 - (0.3 if profile is OWN else 0.0), abs=0.3)
        assert worker.thinned(rows, 1_100_000_000) is None
