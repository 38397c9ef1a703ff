"""From points to cells and tracks: what a rider's life depends on, scan after scan."""

import numpy as np
import pytest

from contract.geometry import Pose2
from tests.vehicle_agent.perception.test_height_map import a_scan
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.signals import PEDESTRIAN, ObstaclePercept, TrackPercept

PERCEPTION = PointPerception(PointGrid(2.4, 3.5, 0.85, 0.82))
PERSON = (0.5, 1.7)


def driven(scans: list[np.ndarray]) -> list[tuple[ObstaclePercept, TrackPercept]]:
    """The percepts of scans 0.1 s apart, of a vehicle that stands."""
    state, percepts = PERCEPTION.initial(), []
    for number, points in enumerate(scans, 1):
        cells, tracks, state = PERCEPTION.step(
            state, points, np.zeros(len(points)), 100_000_000 * number, Pose2(0.0, 0.0, 0.0)
        )
        percepts.append((cells, tracks))
    return percepts


def test_a_person_who_crosses_is_one_track_with_his_speed() -> None:
    percepts = driven([a_scan([(12.0, -3.0 + 0.13 * k, *PERSON)]) for k in range(15)])
    tracks = [track for _, track in percepts[4:]]
    assert {tuple(track.ids) for track in tracks} == {tuple(tracks[0].ids)}
    assert len(tracks[0].ids) == 1
    last = tracks[-1]
    assert last.kinds.tolist() == [PEDESTRIAN]
    assert last.poses_base[0, :2] == pytest.approx((12.0, -3.0 + 0.13 * 14), abs=0.3)
    assert last.velocities_base_mps[0] == pytest.approx((0.0, 1.3), abs=0.35)
    assert last.sizes_m[0, 0] == last.sizes_m[0, 1]


def test_the_same_scans_give_the_same_bytes() -> None:
    scans = [a_scan([(12.0, -3.0 + 0.13 * k, *PERSON), (8.0, 4.0, 1.8, 1.5)]) for k in range(6)]
    for (cells, tracks), (again_cells, again_tracks) in zip(driven(scans), driven(scans), strict=True):
        assert cells.cells_base.tobytes() == again_cells.cells_base.tobytes()
        assert tracks.poses_base.tobytes() == again_tracks.poses_base.tobytes()
        assert tracks.velocities_base_mps.tobytes() == again_tracks.velocities_base_mps.tobytes()


def test_an_empty_scan_is_blind_and_ends_nothing() -> None:
    percepts = driven([a_scan([(12.0, 0.0, *PERSON)])] * 5 + [np.empty((0, 3), np.float32)])
    cells, tracks = percepts[-1]
    assert cells.points_used == 0
    assert tracks.ids.tolist() == percepts[-2][1].ids.tolist()
