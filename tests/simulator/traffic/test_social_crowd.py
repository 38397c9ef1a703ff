"""A reactive crowd: as many as asked for, going about, the same for a seed, and some of them look."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from simulator.traffic.corridor import SAMPLES, SPACING_M
from simulator.traffic.social_crowd import CrowdParams, SocialCrowd
from simulator.traffic.social_force import DONE, GOAL_X, GOAL_Y, LINGER, MARGIN, PACE, REACT, WALK, X, Y

DT_S = 0.02
PATH = np.column_stack((np.arange(81.0), np.zeros(81)))


def shuttle(x_m: float, speed_mps: float) -> tuple[np.ndarray, np.ndarray]:
    """(vehicles, ahead) of one shuttle on the x axis, its rear axle at x_m."""
    ahead = np.zeros((1, SAMPLES, 2))
    ahead[0, :, 0] = x_m + SPACING_M * np.arange(SAMPLES)
    return np.array([[x_m, 0.0, 0.0, 0.85, 3.5, 0.815, speed_mps]]), ahead


def walked(crowd: SocialCrowd, seconds: float, x_m: float = -100.0) -> None:
    vehicles, ahead = shuttle(x_m, 0.0)
    for _ in range(round(seconds / DT_S)):
        crowd.step(vehicles, np.zeros(1), ahead, DT_S)


def one(x_m: float, y_m: float, goal: tuple[float, float], looks: bool, activity: int = WALK) -> SocialCrowd:
    """A crowd of a single person."""
    crowd = SocialCrowd(CrowdParams(0.1), PATH, 1)
    crowd.people, crowd.activity = crowd.people[:1], crowd.activity[:1]
    crowd.attentive, crowd._numbers, crowd._places = (
        np.array([int(looks)]),
        crowd._numbers[:1],
        crowd._places[:1],
    )
    p = crowd.people[0]
    p[:] = 0.0
    p[X], p[Y], (p[GOAL_X], p[GOAL_Y]) = x_m, y_m, goal
    p[PACE], p[MARGIN], p[REACT] = 1.3, 1.0, 0.5
    crowd.activity[0] = activity
    # The clearing around a shuttle that sets off is over.
    crowd._steps = 1
    return crowd


def met(crowd: SocialCrowd, x_m: float, speed_mps: float, seconds: float) -> np.ndarray:
    """(n, 2) the person's way while a shuttle comes from x_m; it does not brake."""
    way = []
    for k in range(round(seconds / DT_S)):
        vehicles, ahead = shuttle(x_m + speed_mps * k * DT_S, speed_mps)
        crowd.step(vehicles, np.zeros(1), ahead, DT_S)
        way.append(crowd.people[0, [X, Y]].copy())
        if crowd.activity[0] == DONE:
            crowd.activity[0] = LINGER
            crowd.people[0, 9] = 1e3
    return np.array(way)


@pytest.mark.parametrize(("density", "reach_m"), [(2.0, 12.0), (6.0, 6.0), (6.0, 12.0), (8.0, 8.0)])
def test_there_are_as_many_people_on_the_path_as_asked_for(density: float, reach_m: float) -> None:
    counts = []
    for seed in range(4):
        crowd = SocialCrowd(CrowdParams(density, reach_m=reach_m), PATH, seed)
        for k in range(3000):
            crowd.step(np.zeros((0, 7)), np.zeros(0), np.zeros((0, 121, 2)), DT_S)
            if k < 500 or k % 50:
                continue
            places = crowd.people[:, [X, Y]]
            counts += [
                (np.hypot(places[:, 0] - x_m, places[:, 1]) < 5.642).sum() for x_m in (20.0, 40.0, 60.0)
            ]
    assert np.mean(counts) == pytest.approx(density, rel=0.12)


def test_a_seed_repeats_the_crowd_bit_for_bit_and_another_does_not() -> None:
    crowds = [SocialCrowd(CrowdParams(5.0), PATH, seed) for seed in (7, 7, 8)]
    for crowd in crowds:
        walked(crowd, 20.0)
    first, again, other = (crowd.bodies().poses_map for crowd in crowds)
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != other.tobytes()


def test_a_dense_crowd_keeps_moving_at_human_speeds_and_apart() -> None:
    crowd = SocialCrowd(CrowdParams(8.0), PATH, 2)
    walked(crowd, 30.0)
    places = crowd.bodies().poses_map[:, :2]
    speeds = np.hypot(*crowd.bodies().velocities_map_mps.T)
    walking = speeds[crowd.activity == WALK]
    assert speeds.max() <= 2.2 + 1e-9
    assert 0.7 < np.median(walking) < 1.6
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) + 9.0 * np.eye(len(places))
    assert np.mean(apart.min(axis=1) < 0.3) < 0.05


def test_people_cross_the_path_in_both_directions() -> None:
    crowd = SocialCrowd(CrowdParams(4.0), PATH, 5)
    sides = np.sign(crowd.people[:, Y])
    walked(crowd, 40.0)
    after = np.sign(crowd.people[:, Y])
    assert ((sides < 0) & (after > 0)).sum() >= 5
    assert ((sides > 0) & (after < 0)).sum() >= 5


def test_who_looks_lets_a_near_shuttle_pass_and_takes_a_long_gap() -> None:
    near = met(one(20.0, 3.0, (20.0, -6.0), True), 8.0, 3.0, 3.0)
    assert near[:, 1].min() > 1.1
    far = met(one(20.0, 3.0, (20.0, -6.0), True), -20.0, 3.0, 6.0)
    assert far[:, 1].min() < -1.3


def test_who_does_not_look_walks_on() -> None:
    way = met(one(20.0, 3.0, (20.0, -6.0), False), -2.0, 3.0, 3.5)
    assert way[:, 1].min() < -0.5


@pytest.mark.parametrize(("looks", "leaves"), [(True, True), (False, False)])
def test_who_looks_makes_room_for_a_shuttle_that_comes(looks: bool, leaves: bool) -> None:
    crowd = one(20.0, 0.2, (20.0, 0.2), looks, LINGER)
    crowd.people[0, 9] = 1e3
    way = met(crowd, 6.0, 1.5, 5.0)
    assert (way[-1, 1] > 1.1) == leaves


def test_who_looks_waits_no_longer_than_the_shuttle_moves() -> None:
    way = met(one(12.0, 3.0, (12.0, -6.0), True), 5.0, 0.0, 8.0)
    assert way[:, 1].min() < -4.0


def test_who_looks_lets_a_shuttle_go_that_has_waited_long() -> None:
    crowd = one(14.0, 3.0, (14.0, -6.0), True)
    vehicles, ahead = shuttle(5.0, 0.0)
    far = crowd.people[0].copy()
    for _ in range(round(11.0 / DT_S)):
        crowd.step(vehicles, np.zeros(1), ahead, DT_S)
        crowd.people[0] = far
    for _ in range(round(4.0 / DT_S)):
        crowd.step(vehicles, np.zeros(1), ahead, DT_S)
    assert crowd.people[0, Y] > 1.1


@pytest.mark.parametrize("start", [(5.5, 3.0), (7.0, 1.4), (9.0, 3.0)])
def test_who_looks_crosses_before_a_standing_shuttle_with_room(start: tuple[float, float]) -> None:
    # The bumper is at 8.5 m.
    way = met(one(*start, (9.0, -6.0), True), 5.0, 0.0, 20.0)
    before = way[np.abs(way[:, 1]) < 0.815]
    assert way[-1, 1] < -4.0
    assert len(before) == 0 or before[:, 0].max() < 5.0 or before[:, 0].min() - 8.5 > 0.8


def test_who_walks_towards_a_standing_shuttle_goes_round_the_nearer_corner() -> None:
    way = met(one(14.0, -0.6, (-10.0, 1.0), True), 5.0, 0.0, 20.0)
    assert way[-1, 0] < -5.0
    beside = way[(way[:, 0] > 4.2) & (way[:, 0] < 8.5)]
    assert (beside[:, 1] < -1.0).all()


@pytest.mark.parametrize("seed", [1, 2])
def test_nobody_who_looks_gets_stuck_before_a_standing_shuttle(seed: int) -> None:
    crowd = SocialCrowd(CrowdParams(6.0, 1.0), PATH, seed)
    # Until people no longer let it go first.
    walked(crowd, 40.0, x_m=40.0)
    since_s, anchors = np.zeros(len(crowd.people)), crowd.people[:, [X, Y]].copy()
    for _ in range(60):
        walked(crowd, 1.0, x_m=40.0)
        places = crowd.people[:, [X, Y]]
        before = (np.abs(places[:, 0] - 45.0) < 1.5) & (np.abs(places[:, 1]) < 1.6) & (crowd.activity == WALK)
        moved = ~before | (np.hypot(*(places - anchors).T) > 0.35)
        anchors[moved], since_s = places[moved], np.where(moved, 0.0, since_s + 1.0)
        assert since_s.max() < 10.0


def test_nobody_is_pushed_into_a_standing_shuttle() -> None:
    crowd = SocialCrowd(CrowdParams(10.0), PATH, 4)
    walked(crowd, 20.0, x_m=40.0)
    places = crowd.bodies().poses_map[:, :2]
    inside = (np.abs(places[:, 1]) < 0.8) & (places[:, 0] > 39.2) & (places[:, 0] < 43.4)
    assert not inside.any()


def test_held_people_are_not_there() -> None:
    crowd = SocialCrowd(CrowdParams(4.0), PATH, 5)
    crowd.hold = True
    before = crowd.people.copy()
    walked(crowd, 1.0)
    assert len(crowd.bodies().numbers) == 0
    assert (crowd.people == before).all()


@pytest.mark.parametrize("looks", [True, False])
@pytest.mark.parametrize(("at", "goal"), [((46.0, 0.3), (20.0, 0.0)), ((41.0, -3.0), (41.0, 6.0))])
def test_nobody_stands_before_a_standing_shuttle_for_ever(
    at: tuple[float, float], goal: tuple[float, float], looks: bool
) -> None:
    way = met(one(*at, goal, looks), 40.0, 0.0, 60.0)
    assert np.hypot(*(way - goal).T).min() < 0.6


@settings(max_examples=60, deadline=None)
@given(
    at=st.tuples(st.floats(43.9, 48.0), st.floats(-1.2, 1.2)),
    goal=st.tuples(st.floats(20.0, 36.0), st.floats(-6.0, 6.0)),
    aside_m=st.floats(-1.2, 1.2),
    looks=st.booleans(),
)
@example(at=(43.9, 0.0), goal=(26.0, -6.0), aside_m=-0.8, looks=True)
def test_whoever_meets_a_standing_shuttle_gets_past_it(
    at: tuple[float, float], goal: tuple[float, float], aside_m: float, looks: bool
) -> None:
    """Wherever it stands on its way: round its body and out of its way may be to different sides."""
    crowd = one(*at, goal, looks)
    vehicles, ahead = shuttle(40.0, 0.0)
    ahead[0, :, 1] = aside_m
    nearest_m = np.inf
    for _ in range(round(40.0 / DT_S)):
        crowd.step(vehicles, np.zeros(1), ahead, DT_S)
        if crowd.activity[0] != WALK:
            break
        nearest_m = min(nearest_m, float(np.hypot(*(crowd.people[0, [X, Y]] - goal))))
    assert nearest_m < 0.6


@pytest.mark.parametrize("looks", [True, False])
def test_who_finds_a_shuttle_where_they_wanted_to_go_goes_somewhere_else(looks: bool) -> None:
    crowd = one(46.0, 0.9, (42.0, 0.1), looks)
    vehicles, ahead = shuttle(40.0, 0.0)
    way = []
    for _ in range(round(60.0 / DT_S)):
        crowd.step(vehicles, np.zeros(1), ahead, DT_S)
        way.append(crowd.people[0, [X, Y]].copy())
    assert np.hypot(*(np.array(way) - (42.0, 0.1)).T).max() > 5.0
