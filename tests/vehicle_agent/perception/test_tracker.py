import math

import msgspec
import numpy as np
import pytest

from contract.geometry import Pose2
from vehicle_agent.perception.tracker import AlphaBetaTracker, TrackerState
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, TrackPercept

STEP_NS = 100_000_000
HERE = Pose2(0.0, 0.0, 0.0)


def a_percept(
    now_ns: int,
    *rows: tuple[int, float, float, float, float],
    kind: int = PEDESTRIAN,
    size_m: tuple[float, float] = (0.5, 0.5),
) -> TrackPercept:
    """rows: id, x, y, vx, vy."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    n = len(table)
    return TrackPercept(
        now_ns,
        table[:, 0].astype(np.int64),
        np.full(n, kind, np.int64),
        np.column_stack((table[:, 1:3], np.zeros(n))),
        table[:, 3:].copy(),
        np.full((n, 2), size_m),
    )


def test_places_and_velocities_are_turned_into_the_map() -> None:
    kept = AlphaBetaTracker().step(
        TrackerState(), a_percept(1, (7, 2.0, 1.0, 1.0, 0.0)), Pose2(10.0, 5.0, math.pi / 2)
    )
    np.testing.assert_allclose(kept.tracks.poses_map[0, :2], (9.0, 7.0))
    np.testing.assert_allclose(kept.tracks.velocities_map_mps[0], (0.0, 1.0), atol=1e-12)
    assert kept.tracks.poses_map[0, 2] == pytest.approx(math.pi / 2)


def turned(percept: TrackPercept, yaw_rad: float) -> TrackPercept:
    """The same with outlines that point that way."""
    return msgspec.structs.replace(percept, poses_base=percept.poses_base + np.array([0.0, 0.0, yaw_rad]))


def test_the_outline_of_a_vehicle_points_as_it_was_seen_whichever_way_it_moves() -> None:
    seen = turned(a_percept(1, (7, 2.0, 1.0, 3.0, -1.0), kind=VEHICLE, size_m=(4.0, 1.8)), 2.0)
    kept = AlphaBetaTracker().step(TrackerState(), seen, Pose2(0.0, 0.0, 2.0))
    assert kept.tracks.poses_map[0, 2] == pytest.approx(4.0 - 2.0 * math.pi)


@pytest.mark.parametrize(
    ("velocity", "heading_rad"),
    [((0.0, 0.5), math.pi / 2), ((-0.5, 0.0), math.pi), ((0.25, -0.25), -math.pi / 4)],
)
def test_somebody_who_walks_faces_where_they_go(velocity: tuple[float, float], heading_rad: float) -> None:
    seen = turned(a_percept(1, (7, 2.0, 1.0, *velocity)), 0.7)
    kept = AlphaBetaTracker().step(TrackerState(), seen, HERE)
    assert kept.tracks.poses_map[0, 2] == pytest.approx(heading_rad)


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (0.3, 0.0), (0.0, -0.3), (0.2, 0.2)])
def test_somebody_who_stands_faces_as_they_were_seen(velocity: tuple[float, float]) -> None:
    seen = turned(a_percept(1, (7, 2.0, 1.0, *velocity)), 0.7)
    kept = AlphaBetaTracker().step(TrackerState(), seen, HERE)
    assert kept.tracks.poses_map[0, 2] == pytest.approx(0.7)


def test_noise_is_smoothed() -> None:
    rng = np.random.default_rng(3)
    keeper, kept, errors = AlphaBetaTracker(), TrackerState(), []
    for k in range(1, 80):
        x_m = 0.12 * k + float(rng.normal(0.0, 0.1))
        percept = a_percept(k * STEP_NS, (1, x_m, 0.0, 1.2 + float(rng.normal(0.0, 0.3)), 0.0))
        kept = keeper.step(kept, percept, HERE)
        errors.append((kept.tracks.poses_map[0, 0] - 0.12 * k, kept.tracks.velocities_map_mps[0, 0] - 1.2))
    place_m, velocity_mps = np.std(errors[20:], axis=0)
    assert place_m < 0.095
    assert velocity_mps < 0.27


def test_who_turns_round_is_known_to_within_a_tenth_of_a_second() -> None:
    keeper, kept, late_mps = AlphaBetaTracker(), TrackerState(), []
    for k in range(1, 15):
        y_mps = max(-1.2, min(1.2, 1.2 - 0.3 * (k - 4)))
        kept = keeper.step(kept, a_percept(k * STEP_NS, (1, 3.0, 0.0, 0.0, y_mps)), HERE)
        late_mps.append(kept.tracks.velocities_map_mps[0, 1] - y_mps)
    assert max(late_mps) < 0.1 * 3.0, "at 3 m/s2"
    assert late_mps[-1] == pytest.approx(0.0, abs=0.02)


def test_who_is_missed_walks_on_for_a_while_and_is_then_forgotten() -> None:
    keeper = AlphaBetaTracker()
    kept = keeper.step(TrackerState(), a_percept(STEP_NS, (1, 5.0, 0.0, 0.0, 1.0)), HERE)
    for k in range(2, 9):
        kept = keeper.step(kept, a_percept(k * STEP_NS), HERE)
    assert kept.tracks.ids.tolist() == [1]
    np.testing.assert_allclose(kept.tracks.poses_map[0, :2], (5.0, 0.7), atol=1e-9)
    for k in range(9, 12):
        kept = keeper.step(kept, a_percept(k * STEP_NS), HERE)
    assert not len(kept.tracks.ids)


def test_ids_and_the_times_they_were_seen_stay_together() -> None:
    keeper = AlphaBetaTracker()
    kept = keeper.step(
        TrackerState(), a_percept(STEP_NS, (9, 1.0, 0.0, 0.0, 0.0), (2, 3.0, 0.0, 0.0, 0.0)), HERE
    )
    kept = keeper.step(kept, a_percept(2 * STEP_NS, (9, 1.0, 0.0, 0.0, 0.0)), HERE)
    assert kept.tracks.ids.tolist() == [2, 9]
    assert kept.seen_ns.tolist() == [STEP_NS, 2 * STEP_NS]


@pytest.mark.parametrize(
    ("row", "size_m"),
    [
        ((1, math.nan, 0.0, 0.0, 0.0), (0.5, 0.5)),
        ((1, 5.0, math.inf, 0.0, 0.0), (0.5, 0.5)),
        ((1, 5.0, 0.0, 1e6, 0.0), (0.5, 0.5)),
        ((1, 5.0, 0.0, 0.0, 0.0), (-1.0, 0.5)),
        ((1, 5.0, 0.0, 0.0, 0.0), (500.0, 3.0)),
    ],
)
def test_an_absurd_track_is_not_believed(
    row: tuple[int, float, float, float, float], size_m: tuple[float, float]
) -> None:
    kept = AlphaBetaTracker().step(TrackerState(), a_percept(1, row, size_m=size_m), HERE)
    assert not len(kept.tracks.ids)


def test_a_number_told_twice_counts_once() -> None:
    percept = a_percept(1, (1, 5.0, 0.0, 0.0, 0.0), (1, 9.0, 0.0, 0.0, 0.0), kind=VEHICLE, size_m=(4.0, 2.0))
    kept = AlphaBetaTracker().step(TrackerState(), percept, HERE)
    assert kept.tracks.ids.tolist() == [1]
    assert kept.tracks.poses_map[0, 0] == 5.0


@pytest.mark.parametrize(
    ("row", "size_m", "believed"),
    [
        ((1, 5.0, 0.0, 24.9, 0.0), (0.5, 0.5), True),
        ((1, 5.0, 0.0, 20.0, 16.0), (0.5, 0.5), False),
        ((1, 5.0, 0.0, 0.0, 0.0), (25.0, 3.0), True),
        ((1, 5.0, 0.0, 0.0, 0.0), (3.0, 25.1), False),
        ((1, 5.0, 0.0, 0.0, 0.0), (0.5, 0.0), False),
        ((1, -9_999.0, 9_999.0, 0.0, 0.0), (0.5, 0.5), True),
        ((1, 0.0, -10_001.0, 0.0, 0.0), (0.5, 0.5), False),
    ],
)
def test_what_drives_on_a_campus_is_slower_than_25_mps_and_shorter_than_25_m(
    row: tuple[int, float, float, float, float], size_m: tuple[float, float], believed: bool
) -> None:
    kept = AlphaBetaTracker().step(TrackerState(), a_percept(1, row, size_m=size_m), HERE)
    assert bool(len(kept.tracks.ids)) == believed


def test_a_track_whose_heading_was_counted_over_many_turns_is_kept_with_the_heading_it_has() -> None:
    seen = turned(
        a_percept(1, (7, 2.0, 1.0, 0.0, 0.0), kind=VEHICLE, size_m=(4.0, 1.8)), 4000.0 * math.pi + 0.5
    )
    kept = AlphaBetaTracker().step(TrackerState(), seen, HERE)
    assert kept.tracks.poses_map[0, 2] == pytest.approx(0.5)


@pytest.mark.parametrize(("kind", "believed"), [(-1, False), (0, True), (3, True), (4, False)])
def test_only_the_kinds_of_the_vocabulary_are_believed(kind: int, believed: bool) -> None:
    kept = AlphaBetaTracker().step(TrackerState(), a_percept(1, (1, 5.0, 0.0, 0.0, 0.0), kind=kind), HERE)
    assert bool(len(kept.tracks.ids)) == believed


def test_one_absurd_track_does_not_take_the_others_with_it() -> None:
    rows = (4, 5.0, 0.0, 0.0, 0.0), (5, math.nan, 0.0, 0.0, 0.0), (6, 8.0, 0.0, 0.0, 0.0)
    kept = AlphaBetaTracker().step(TrackerState(), a_percept(1, *rows), HERE)
    assert kept.tracks.ids.tolist() == [4, 6]


def test_a_missed_track_keeps_its_kind_size_and_velocity_between_those_that_were_seen() -> None:
    keeper = AlphaBetaTracker()
    car = a_percept(STEP_NS, (5, 1.0, 2.0, 3.0, 4.0), kind=VEHICLE, size_m=(4.0, 1.8))
    kept = keeper.step(TrackerState(), car, HERE)
    people = a_percept(2 * STEP_NS, (9, 0.0, 0.0, 0.0, 0.0), (2, 7.0, 0.0, 0.0, 0.0))
    tracks = keeper.step(kept, people, HERE).tracks
    assert tracks.ids.tolist() == [2, 5, 9]
    assert tracks.kinds.tolist() == [PEDESTRIAN, VEHICLE, PEDESTRIAN]
    assert tracks.sizes_m.tolist() == [[0.5, 0.5], [4.0, 1.8], [0.5, 0.5]]
    np.testing.assert_allclose(tracks.poses_map[:, :2], [[7.0, 0.0], [1.3, 2.4], [0.0, 0.0]])
    np.testing.assert_allclose(tracks.velocities_map_mps[1], (3.0, 4.0))
    assert tracks.stamp_ns == 2 * STEP_NS


def test_the_first_look_at_somebody_is_taken_as_it_is_and_later_ones_correct_what_was_expected() -> None:
    keeper = AlphaBetaTracker()
    kept = keeper.step(TrackerState(), a_percept(STEP_NS, (1, 5.0, 0.0, 1.0, 0.0)), HERE)
    np.testing.assert_allclose(kept.tracks.poses_map[0, :2], (5.0, 0.0))
    kept = keeper.step(kept, a_percept(2 * STEP_NS, (1, 5.2, 0.0, 2.0, 0.0)), HERE)
    # Expected at 5.1 m with 1 m/s: six tenths of the way to 5.2 m, eight tenths to 2 m/s.
    np.testing.assert_allclose(kept.tracks.poses_map[0, :2], (5.16, 0.0))
    np.testing.assert_allclose(kept.tracks.velocities_map_mps[0], (1.8, 0.0))


def test_a_second_look_of_the_same_moment_is_taken_as_it_is() -> None:
    keeper = AlphaBetaTracker()
    kept = keeper.step(TrackerState(), a_percept(STEP_NS, (1, 5.0, 0.0, 1.0, 0.0)), HERE)
    kept = keeper.step(kept, a_percept(STEP_NS, (1, 6.0, 0.0, 0.0, 0.0)), HERE)
    np.testing.assert_allclose(kept.tracks.poses_map[0, :2], (6.0, 0.0))
