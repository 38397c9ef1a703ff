import numpy as np
import pytest

from contract.geometry import Array
from vehicle_agent.planning.behaviour.offsets import (
    COST,
    FREE_M,
    RATINGS,
    RISK,
    Blend,
    Movers,
    OffsetRules,
    Stations,
    blended,
    choose,
    rate,
)
from vehicle_agent.planning.motion.clearance import Box

RULES = OffsetRules()
CANDIDATES = np.array([-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9])
N = 100


def rated(
    discs: Array | None = None, moving: Movers | None = None, room_m: float = 1.5, speed_mps: float = 3.0
) -> Array:
    points = np.column_stack((0.5 * np.arange(N), np.zeros(N)))
    room = np.full(N, room_m)
    last = 10 + round(RULES.look_m / 0.5)
    return np.asarray(
        rate(
            Stations(
                points, np.zeros(N), np.zeros(N), -room, room, step_m=0.5, first=10, last=last, stride=2
            ),
            CANDIDATES,
            Blend(now_m=0.0, slope=0.0, blend_m=8.0),
            speed_mps,
            np.empty((0, 3)) if discs is None else discs,
            walkers() if moving is None else moving,
            Box(3.5, 0.85, 0.815),
            RULES,
        )
    )


def walkers(*ways: Array) -> Movers:
    """People of half a metre on ways (10, 2), at 0.5 s, 1 s, ..."""
    poses = np.zeros((len(ways), 10, 3))
    for k, way in enumerate(ways):
        poses[k, :, :2] = way
    return Movers(poses, np.full((len(ways), 2), 0.5), np.full((len(ways), 10), 0.1))


def costs(*values: float) -> Array:
    ratings = np.zeros((len(values), RATINGS))
    ratings[:, COST], ratings[:, FREE_M] = values, np.inf
    return ratings


def test_on_a_free_road_the_middle_is_kept() -> None:
    ratings = rated()
    assert CANDIDATES[int(np.argmin(ratings[:, COST]))] == 0.0
    assert np.isinf(ratings[:, FREE_M]).all()


def test_something_that_stands_on_one_side_is_passed_on_the_other() -> None:
    ratings = rated(np.array([[25.0, 0.9, 0.3]]))
    best = int(np.argmin(ratings[:, COST]))
    assert CANDIDATES[best] < 0.0
    assert np.isinf(ratings[best, FREE_M])
    assert ratings[3, FREE_M] == pytest.approx(25.0 - 5.0 - 3.5 - 0.4, abs=1.1)


def test_a_way_that_soon_ends_is_no_better_for_whom_it_never_meets() -> None:
    """People everywhere, and something that stands on the left: a vehicle that chose the left would meet none
    of them, and stand."""
    ways = [np.tile((x, y), (10, 1)) for x in (13.0, 16.0, 19.0) for y in (-1.2, -0.4, 0.4, 1.2)]
    ratings = rated(np.array([[11.0, 1.1, 0.3]]), walkers(*ways), speed_mps=1.5)
    best = int(np.argmin(ratings[:, COST]))
    assert ratings[-1, FREE_M] <= 3.0
    assert CANDIDATES[best] < 0.0
    assert np.isinf(ratings[best, FREE_M])


def test_a_lane_without_room_is_no_choice() -> None:
    ratings = rated(room_m=0.5)
    assert np.isinf(ratings[np.abs(CANDIDATES) > 0.5, COST]).all()
    assert np.isfinite(ratings[np.abs(CANDIDATES) <= 0.5, COST]).all()


def test_who_walks_on_one_side_makes_that_side_dear() -> None:
    t = 0.5 * np.arange(1, 11)
    ratings = rated(moving=walkers(np.column_stack((17.0 + t, 1.5 - 0.02 * t))))
    assert ratings[-1, RISK] > ratings[0, RISK]
    assert ratings[-1, COST] > ratings[0, COST] + 0.1


def test_who_is_predicted_to_turn_away_makes_no_side_dear() -> None:
    """Risk is where people are expected to be, not where their present velocity would lead."""
    t = 0.5 * np.arange(1, 11)
    straight = np.column_stack((17.0 + 0.0 * t, 3.0 - 0.8 * t))
    turns = np.column_stack((17.0 + 0.0 * t, 3.0 + 0.8 * t))
    assert rated(moving=walkers(straight))[:, RISK].max() > 0.0
    assert rated(moving=walkers(turns))[:, RISK].max() == 0.0


def test_a_change_of_lane_waits_until_it_has_been_better_for_some_plans() -> None:
    ratings, better_m, count = costs(5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 1.0), 0.0, 0
    for plan in range(RULES.patience + 1):
        chosen = choose(RULES, CANDIDATES, ratings, 0.0, better_m, count)
        better_m, count = chosen.better_offset_m, chosen.better_count
        assert chosen.offset_m == (0.9 if plan == RULES.patience else 0.0)


def test_a_small_step_is_taken_at_once_and_a_small_gain_never() -> None:
    assert choose(RULES, CANDIDATES, costs(5, 5, 5, 5, 1, 5, 5), 0.0, 0.0, 0).offset_m == 0.3
    assert choose(RULES, CANDIDATES, costs(5, 5, 5, 5, 4.9, 5, 5), 0.0, 0.0, 0).offset_m == 0.0


def test_noisy_costs_do_not_make_the_vehicle_weave() -> None:
    rng = np.random.default_rng(5)
    offset_m, better_m, count, changes = 0.0, 0.0, 0, 0
    for _ in range(200):
        noisy = costs(*(5.0 + 0.5 * np.abs(CANDIDATES) + rng.normal(0.0, 0.4, len(CANDIDATES))))
        chosen = choose(RULES, CANDIDATES, noisy, offset_m, better_m, count)
        changes += chosen.offset_m != offset_m and abs(chosen.offset_m - offset_m) > RULES.threshold_m
        offset_m, better_m, count = chosen.offset_m, chosen.better_offset_m, chosen.better_count
    assert changes <= 2


def test_with_no_room_at_all_there_is_no_free_way() -> None:
    assert choose(RULES, CANDIDATES, costs(*[np.inf] * 7), 0.3, 0.3, 0).free_m == 0.0


def test_a_blend_leaves_and_arrives_smoothly() -> None:
    assert blended(0.4, 0.1, -0.6, 0.0, 8.0) == pytest.approx((0.4, 0.1))
    assert blended(0.4, 0.1, -0.6, 8.0, 8.0) == pytest.approx((-0.6, 0.0))


def test_who_stands_at_the_flank_or_behind_does_not_end_the_free_way() -> None:
    flank, behind = [6.0, 0.815 + 0.25 + 0.03, 0.25], [4.0, 0.3, 0.25]
    assert np.isinf(rated(np.array([flank, behind]))[CANDIDATES <= 0.0, FREE_M]).all()


def test_who_stands_at_the_bumper_leaves_no_free_way() -> None:
    assert (rated(np.array([[5.0 + 3.5 + 0.3, 0.0, 0.25]]))[:, FREE_M] < 1.5).all()
