"""Cells and tracks together: their stamp, which cells belong to a track, and which are remembered."""

import numpy as np
import pytest

from contract.geometry import Pose2
from vehicle_agent.perception.cells import HeightMapPerception
from vehicle_agent.perception.tracks import TrackingPerception, TracksState
from vehicle_agent.signals import PEDESTRIAN, Detections, Ego, ObstaclePercept, Percept, TrackPercept

ROOM = TrackingPerception(HeightMapPerception(3.2, 2.28, np.radians(-15.0), 3.5, 0.85, 0.815))
TICK_NS = 20_000_000


def an_ego(now_ns: int, x_m: float = 0.0) -> Ego:
    return Ego(now_ns, Pose2(x_m, 0.0, 0.0), 2.0, 0.0, 0.0, 0.0, 0.02, now_ns, True)


def cells(stamp_ns: int, *places: tuple[float, float], used: int = 100) -> ObstaclePercept:
    return ObstaclePercept(stamp_ns, np.array(places).reshape(-1, 2), np.ones(len(places)), used)


def people(stamp_ns: int, *rows: tuple[int, float, float]) -> TrackPercept:
    """rows: id, x, y in the base frame; all stand."""
    n = len(rows)
    table = np.array(rows, dtype=np.float64).reshape(-1, 3)
    return TrackPercept(
        stamp_ns,
        table[:, 0].astype(np.int64),
        np.full(n, PEDESTRIAN, np.int64),
        np.column_stack((table[:, 1:], np.zeros(n))),
        np.zeros((n, 2)),
        np.full((n, 2), 0.5),
    )


def step(
    state: TracksState, now_ns: int, *percepts: Percept, room: TrackingPerception = ROOM, x_m: float = 0.0
) -> tuple[Detections, TracksState]:
    return room.step(state, percepts, an_ego(now_ns, x_m))


def test_the_detections_are_as_old_as_the_older_of_scan_and_tracks() -> None:
    """The guard judges their age: a tracker that stopped must not hide behind a lidar that goes on."""
    _, state = step(ROOM.initial(), 5 * TICK_NS, cells(4 * TICK_NS, (10.0, 0.0)), people(3 * TICK_NS))
    seen, state = step(state, 10 * TICK_NS, cells(9 * TICK_NS, (10.0, 0.0)))
    assert seen.stamp_ns == 3 * TICK_NS
    seen, _ = step(state, 11 * TICK_NS, people(10 * TICK_NS))
    assert seen.stamp_ns == 9 * TICK_NS


def test_a_vehicle_without_lidar_has_the_age_of_its_tracks_and_is_not_blind() -> None:
    room = TrackingPerception(ROOM.cells, has_lidar=False)
    seen, _ = step(room.initial(), 5 * TICK_NS, people(4 * TICK_NS, (1, 8.0, 0.0)), room=room)
    assert (seen.stamp_ns, seen.blind) == (4 * TICK_NS, False)
    assert seen.tracks.ids.tolist() == [1]


def test_a_blind_lidar_is_told_though_there_are_tracks() -> None:
    seen, _ = step(ROOM.initial(), 5 * TICK_NS, cells(4 * TICK_NS, used=0), people(4 * TICK_NS))
    assert seen.blind


def test_the_same_object_is_given_until_either_is_newer() -> None:
    seen, state = step(ROOM.initial(), 5 * TICK_NS, cells(4 * TICK_NS, (10.0, 0.0)), people(4 * TICK_NS))
    again, state = step(state, 6 * TICK_NS)
    assert again is seen
    again, state = step(state, 7 * TICK_NS, people(4 * TICK_NS, (1, 8.0, 0.0)))
    assert again is seen, "an older percept that comes late"
    newer, state = step(state, 8 * TICK_NS, people(7 * TICK_NS, (1, 8.0, 0.0)))
    assert newer.tracks.ids.tolist() == [1]
    scanned, _ = step(state, 9 * TICK_NS, cells(8 * TICK_NS, (11.0, 0.0)))
    np.testing.assert_allclose(scanned.points_map, [[11.0, 0.0]], atol=1e-8)


def test_tracks_are_moved_with_the_pose_at_their_scan() -> None:
    state = ROOM.initial()
    for k in range(1, 11):
        _, state = step(state, k * TICK_NS, x_m=0.04 * k)
    seen, _ = step(state, 11 * TICK_NS, people(5 * TICK_NS, (1, 8.0, 1.0)), x_m=0.44)
    np.testing.assert_allclose(seen.tracks.poses_map[0, :2], (8.2, 1.0))


def test_two_looks_that_come_at_once_count_in_their_order() -> None:
    late_first = people(3 * TICK_NS, (1, 8.0, 1.0)), people(2 * TICK_NS, (1, 8.0, 0.0), (2, 9.0, 0.0))
    seen, _ = step(ROOM.initial(), 4 * TICK_NS, *late_first)
    assert seen.tracks.ids.tolist() == [1, 2], "the second person is missed by the newer look"
    assert seen.tracks.stamp_ns == 3 * TICK_NS


@pytest.mark.parametrize(("beside_m", "is_theirs"), [(0.25 + 0.45, True), (0.25 + 0.55, False)])
def test_a_cell_of_a_person_who_is_tracked_is_not_remembered_in_the_blind_zone(
    beside_m: float, is_theirs: bool
) -> None:
    """The person walks on; a remembered cell would keep the shuttle standing before nothing."""
    cell = (5.0 + beside_m, 0.3)
    _, state = step(ROOM.initial(), TICK_NS, cells(TICK_NS, cell), people(TICK_NS, (1, 5.0, 0.3)))
    seen, _ = step(state, 6 * TICK_NS, cells(6 * TICK_NS), people(6 * TICK_NS, (1, 5.0, 2.5)))
    assert len(seen.points_map) == (0 if is_theirs else 1)
