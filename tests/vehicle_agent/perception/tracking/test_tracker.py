"""Tracks: identities, velocities soon enough to plan by, and nothing that moves without moving."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array, Pose2
from vehicle_agent.perception.tracking.motion import combined, predict, update
from vehicle_agent.perception.tracking.tracker import ObjectTracker
from vehicle_agent.perception.tracking.tracks import ObjectTrackerState
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE, TrackPercept
from vehicle_agent.signals.objects import SeenObjects

TRACKER = ObjectTracker(viewpoint_x_m=0.0)
HERE = Pose2(0.0, 0.0, 0.0)
SIZES = {
    PEDESTRIAN: (0.5, 0.5, 1.7),
    CYCLIST: (1.8, 0.6, 1.7),
    VEHICLE: (4.4, 1.8, 1.5),
    OTHER: (0.6, 0.6, 1.0),
}


def seen(number: int, places: Array, kind: int = PEDESTRIAN, score: float = 0.8) -> SeenObjects:
    """Objects of one kind at places (n, 2), as clusters give them: without velocities."""
    n = len(places)
    return SeenObjects(
        1_000_000_000 + 100_000_000 * number, np.full(n, kind), np.full(n, score),
        np.column_stack((places, np.zeros(n))).reshape(-1, 3), np.tile(SIZES[kind], (n, 1)),
        np.full((n, 2), math.nan),
    )  # fmt: skip


def tracked(
    places: list[Array], kind: int = PEDESTRIAN, noise_m: float = 0.06, seed: int = 1, score: float = 0.8
) -> tuple[list[TrackPercept], ObjectTrackerState]:
    """The percepts of scans 0.1 s apart."""
    rng = np.random.default_rng(seed)
    state, percepts = TRACKER.initial(), []
    for number, frame in enumerate(places):
        noisy = frame + rng.normal(0.0, noise_m, frame.shape)
        percept, state = TRACKER.step(state, seen(number, noisy, kind, score), HERE)
        percepts.append(percept)
    return percepts, state


def walk(steps: int, begin: tuple[float, float], velocity: tuple[float, float]) -> list[Array]:
    return [
        np.array([[begin[0] + 0.1 * k * velocity[0], begin[1] + 0.1 * k * velocity[1]]]) for k in range(steps)
    ]


def test_a_person_who_starts_is_seen_to_walk_within_0_3_s() -> None:
    late = []
    for seed in range(10):
        percepts, _ = tracked(
            walk(20, (10.0, 2.0), (0.0, 0.0)) + walk(6, (10.0, 1.87), (0.0, -1.3)), seed=seed
        )
        speeds = [-float(p.velocities_base_mps[0, 1]) for p in percepts[20:]]
        late.append(next(k for k, speed in enumerate(speeds) if speed > 0.5) + 1)
    assert np.mean(late) <= 3.0
    assert max(late) <= 4


def test_a_person_who_turns_round_is_seen_to_within_0_3_s() -> None:
    for seed in range(5):
        percepts, _ = tracked(
            walk(20, (10.0, 0.0), (0.0, -1.3)) + walk(4, (10.0, -2.34), (0.0, 1.3)), seed=seed
        )
        assert percepts[22].velocities_base_mps[0, 1] > 0.0
        assert percepts[22].ids.tolist() == percepts[10].ids.tolist()


def test_measured_velocities_that_are_wrong_now_and_then_do_not_turn_a_person() -> None:
    """In a crowd a shift may be measured to another person's returns: here every third is off by metres."""
    rng = np.random.default_rng(7)
    state, off_mps = TRACKER.initial(), []
    for number, place in enumerate(walk(80, (10.0, 4.0), (0.0, -1.2))):
        measured = np.array([0.0, -1.2]) + rng.normal(0.0, 0.2, 2)
        if rng.random() < 0.35:
            measured = rng.uniform(-2.5, 2.5, 2)
        found = seen(number, place + rng.normal(0.0, 0.04, (1, 2)))
        with_shift = SeenObjects(
            found.stamp_ns, found.kinds, found.scores, found.poses_base, found.sizes_m, measured[None, :]
        )
        percept, state = TRACKER.step(state, with_shift, HERE)
        if number >= 10:
            off_mps.append(float(np.hypot(*(percept.velocities_base_mps[0] - (0.0, -1.2)))))
    assert np.sqrt(np.mean(np.square(off_mps))) < 0.35
    assert max(off_mps) < 1.0


def test_a_person_who_sets_off_gently_is_followed_by_measured_shifts() -> None:
    """1 m/s2 for a second; shifts with the errors of recorded crowds, places with those of a network."""
    behind_mps = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        state = TRACKER.initial()
        for number in range(30):
            since_s = max(0.0, 0.1 * (number - 20))
            speed_mps, way_m = since_s, 0.5 * since_s**2
            found = seen(number, np.array([[8.0, 2.0 - way_m]]) + rng.normal(0.0, 0.04, (1, 2)))
            with_shift = SeenObjects(
                found.stamp_ns, found.kinds, found.scores, found.poses_base, found.sizes_m,
                np.array([[0.0, -speed_mps]]) + rng.normal(0.0, 0.2, (1, 2)),
            )  # fmt: skip
            percept, state = TRACKER.step(state, with_shift, HERE)
            if number > 24:
                behind_mps.append(speed_mps + float(percept.velocities_base_mps[0, 1]))
    assert np.mean(behind_mps) < 0.2
    assert np.percentile(behind_mps, 95) < 0.45


def test_who_stands_has_almost_no_velocity() -> None:
    percepts, _ = tracked(walk(60, (10.0, 2.0), (0.0, 0.0)))
    speeds = [float(np.hypot(*p.velocities_base_mps[0])) for p in percepts[10:]]
    assert np.percentile(speeds, 95) < 0.15


def test_identities_survive_a_crossing_and_are_never_used_twice() -> None:
    one, other = walk(40, (8.0, -2.0), (0.0, 1.0)), walk(40, (8.6, 2.0), (0.0, -1.0))
    percepts, state = tracked([np.vstack(pair) for pair in zip(one, other, strict=True)])
    first, last = percepts[5], percepts[-1]
    assert first.ids.tolist() == last.ids.tolist()
    upper = [int(p.ids[np.argmax(p.poses_base[:, 1])]) for p in (first, last)]
    assert upper[0] != upper[1], "they have changed sides, not their names"
    for number in range(40, 60):
        percept, state = TRACKER.step(state, seen(number, np.empty((0, 2))), HERE)
    assert len(percept.ids) == 0
    for number in range(60, 66):
        percept, state = TRACKER.step(state, seen(number, np.array([[8.0, 0.0]])), HERE)
    assert percept.ids.min() > max(first.ids)


def test_a_person_behind_another_comes_back_as_the_same() -> None:
    standing, passing = np.array([6.0, 0.0]), walk(30, (9.0, -1.5), (0.0, 1.0))
    frames = []
    for place in passing:
        is_hidden = abs(place[0, 1]) < 0.35
        frames.append(standing[None] if is_hidden else np.vstack((standing, place)))
    percepts, _ = tracked(frames)
    assert percepts[10].ids.tolist() == percepts[-1].ids.tolist()
    assert len(percepts[15].ids) == 2, "shown while hidden, too"


def test_two_objects_of_one_scan_make_no_track() -> None:
    percepts, _ = tracked(
        [np.array([[8.0, 0.0]]), np.array([[8.0, 0.0]]), np.empty((0, 2)), np.empty((0, 2))]
    )
    assert all(len(percept.ids) == 0 for percept in percepts)


def test_the_side_of_a_parked_car_that_comes_into_view_does_not_move_it() -> None:
    state, speeds = TRACKER.initial(), []
    for number in range(30):
        # First its rear alone is seen, then more and more of its side.
        length = min(4.4, 0.4 + 0.2 * number)
        objects = SeenObjects(
            1_000_000_000 + 100_000_000 * number, np.array([VEHICLE]), np.array([0.9]),
            np.array([[10.0 + 0.5 * length, 3.0, 0.0]]), np.array([[length, 1.8, 1.5]]),
            np.full((1, 2), math.nan),
        )  # fmt: skip
        percept, state = TRACKER.step(state, objects, HERE)
        if number > 8:
            speeds.append(float(np.hypot(*percept.velocities_base_mps[0])))
    assert max(speeds) < 0.6
    assert percept.poses_base[0, :2] == pytest.approx((12.2, 3.0), abs=0.4)


def test_a_cyclist_in_a_bend_is_followed() -> None:
    frames = [np.array([[10.0 * math.sin(0.04 * k), 10.0 - 10.0 * math.cos(0.04 * k)]]) for k in range(50)]
    percepts, _ = tracked(frames, CYCLIST)
    last = percepts[-1]
    assert len(last.ids) == 1
    angle = 0.04 * 49
    assert last.velocities_base_mps[0] == pytest.approx(
        (4.0 * math.cos(angle), 4.0 * math.sin(angle)), abs=0.6
    )
    assert last.poses_base[0, 2] == pytest.approx(angle, abs=0.25)


def test_what_is_faster_than_people_run_becomes_a_cyclist() -> None:
    percepts, _ = tracked(walk(30, (2.0, 0.0), (4.5, 0.0)))
    assert percepts[-1].kinds.tolist() == [CYCLIST]


def test_things_of_no_kind_are_shown_only_while_they_move() -> None:
    still, _ = tracked(walk(30, (9.0, 2.0), (0.0, 0.0)), OTHER, score=0.9)
    moving, _ = tracked(walk(30, (9.0, -2.0), (0.0, 1.2)), OTHER, score=0.9)
    assert len(still[-1].ids) == 0
    assert moving[-1].kinds.tolist() == [OTHER]


def test_velocities_that_a_network_measures_are_used_at_once() -> None:
    state = TRACKER.initial()
    for number in range(3):
        objects = seen(number, np.array([[12.0 - 0.4 * number, 3.0]]), VEHICLE)
        with_velocity = SeenObjects(
            objects.stamp_ns, objects.kinds, objects.scores, objects.poses_base, objects.sizes_m,
            np.array([[-4.0, 0.0]]),
        )  # fmt: skip
        percept, state = TRACKER.step(state, with_velocity, HERE)
    assert percept.velocities_base_mps[0] == pytest.approx((-4.0, 0.0), abs=0.3)


def test_the_vehicle_s_own_motion_is_not_the_others() -> None:
    state = TRACKER.initial()
    for number in range(20):
        pose = Pose2(0.3 * number, 0.0, 0.02 * number)
        cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        dx, dy = 15.0 - pose.x_m, 3.0
        percept, state = TRACKER.step(
            state, seen(number, np.array([[cos * dx + sin * dy, cos * dy - sin * dx]])), pose
        )
    assert np.hypot(*percept.velocities_base_mps[0]) < 0.1


def test_a_late_scan_changes_nothing() -> None:
    percepts, state = tracked(walk(10, (8.0, 0.0), (0.0, 1.0)))
    percept, after = TRACKER.step(state, seen(5, np.array([[3.0, 3.0]])), HERE)
    assert after is state
    assert percept.ids.tolist() == percepts[-1].ids.tolist()


def test_after_a_long_gap_tracks_are_new() -> None:
    percepts, state = tracked(walk(10, (8.0, 0.0), (0.0, 0.0)))
    for number in range(40, 45):
        percept, state = TRACKER.step(state, seen(number, np.array([[8.0, 0.0]])), HERE)
    assert percept.ids.min() > percepts[-1].ids.max()


def test_objects_that_are_no_numbers_are_left_out() -> None:
    state = TRACKER.initial()
    for number in range(5):
        objects = seen(number, np.array([[8.0, 0.0], [math.nan, 1.0]]))
        percept, state = TRACKER.step(state, objects, HERE)
    assert len(percept.ids) == 1


@settings(max_examples=30, deadline=None)
@given(
    steps=st.lists(
        st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.booleans()), min_size=3, max_size=25
    ),
    turns=st.booleans(),
)
def test_the_filter_stays_finite_and_its_covariance_positive(
    steps: list[tuple[float, float, bool]], turns: bool
) -> None:
    means, covariances = (
        np.zeros((1, 2, 5)),
        np.tile(np.diag([0.01, 0.01, 1.0, 1.0, 0.05 * turns]), (1, 2, 1, 1)),
    )
    weights = np.full((1, 2), 0.5)
    noise = np.array([[[0.3, 0.1 * turns], [5.0, 0.8 * turns]]])
    for x, y, is_seen in steps:
        predict(means, covariances, weights, noise, 0.93, 0.1)
        if is_seen:
            update(
                means, covariances, weights, np.array([0]), np.array([[x, y, math.nan, math.nan, 0.01, 0.1]])
            )
        assert np.isfinite(means).all()
        assert weights.sum() == pytest.approx(1.0)
    _, covariance = combined(means, covariances, weights)
    assert np.linalg.eigvalsh(covariance[0]).min() > -1e-9


def fitted_car(number: int, place: tuple[float, float], yaw_rad: float, length_m: float = 4.4) -> SeenObjects:
    """A car whose box is fitted to its returns."""
    return SeenObjects(
        1_000_000_000 + 100_000_000 * number, np.array([VEHICLE]), np.array([0.8]),
        np.array([[*place, yaw_rad]]), np.array([[length_m, 1.8, 1.5]]), np.full((1, 2), math.nan),
        np.array([True]),
    )  # fmt: skip


def test_a_car_that_leaves_its_bay_is_seen_to_move_within_0_3_s() -> None:
    for seed in range(5):
        rng, state = np.random.default_rng(seed), TRACKER.initial()
        for number in range(33):
            y_m = -6.0 + 0.22 * max(0, number - 29)
            place = (8.0 + float(rng.normal(0.0, 0.03)), y_m + float(rng.normal(0.0, 0.03)))
            percept, state = TRACKER.step(state, fitted_car(number, place, 0.5 * math.pi), HERE)
        assert percept.velocities_base_mps[0, 1] > 1.2
        assert abs(percept.velocities_base_mps[0, 0]) < 0.4


def test_a_car_goes_on_where_its_bonnet_is_below_the_beams() -> None:
    """It drives by before the bumper; what is nearest to the vehicle's axis is not seen any more."""
    tracker = ObjectTracker(viewpoint_x_m=1.3, blind_m=(-2.5, 5.2, 2.5))
    state, speed_mps = tracker.initial(), 0.8
    for number in range(60):
        y_m = 1.0 - 0.08 * number
        ends = y_m - 2.2, min(y_m + 2.2, -0.7 if number > 30 else 9.0)
        middle, length = 0.5 * (ends[0] + ends[1]), ends[1] - ends[0]
        car = fitted_car(number, (5.0, middle), 0.5 * math.pi, length)
        percept, state = tracker.step(state, car, HERE)
        if number > 10:
            assert percept.poses_base[0, 1] == pytest.approx(y_m, abs=0.3)
            assert percept.velocities_base_mps[0, 1] == pytest.approx(-speed_mps, abs=0.35)
    assert percept.sizes_m[0, 0] == pytest.approx(4.4, abs=0.2)


def test_a_car_that_was_taken_to_stand_across_has_its_length_along_its_motion() -> None:
    state = TRACKER.initial()
    for number in range(12):
        # Of a car in a bay only the face is seen at first: as long as it is wide, it seems to lie across.
        car = fitted_car(
            number,
            (8.0, -6.0 + 0.2 * number),
            0.0 if number < 2 else 0.5 * math.pi,
            2.2 if number < 2 else 4.4,
        )
        percept, state = TRACKER.step(state, car, HERE)
    assert abs(math.remainder(percept.poses_base[0, 2] - 0.5 * math.pi, math.pi)) < 0.3
    assert percept.sizes_m[0, 0] > 3.5
    assert percept.sizes_m[0, 1] < 2.3
