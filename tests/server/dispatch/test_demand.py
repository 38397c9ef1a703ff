"""Rates learned from past pickups, and where idle vehicles wait best by them."""

from datetime import date, timedelta
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from contract.geometry import Array
from server.dispatch.demand import FREE_DAY, WORKDAY, DemandWeights, Pickup, learned_rates
from server.dispatch.waiting_places import best_move, mean_wait_s

TODAY = date(2026, 11, 23)
MEMORY = DemandWeights()
STOPS = 3


def kind_of(day: date) -> int:
    return FREE_DAY if day.weekday() >= 5 else WORKDAY


def every_workday(weeks: int, per_day: int, stop: int = 1, hour: int = 8) -> list[Pickup]:
    days = [TODAY - timedelta(days=back) for back in range(1, 7 * weeks + 1)]
    return [Pickup(stop, day, hour) for day in days if kind_of(day) == WORKDAY for _ in range(per_day)]


def rates(pickups: list[Pickup], memory: DemandWeights = MEMORY) -> Array:
    return learned_rates(pickups, TODAY, kind_of, STOPS, memory)


PICKUPS = st.lists(
    st.builds(
        Pickup,
        st.integers(0, STOPS - 1),
        st.integers(1, 50).map(lambda back: TODAY - timedelta(days=back)),
        st.integers(0, 23),
    ),
    max_size=30,
)


@given(PICKUPS)
def test_rates_are_never_more_than_was_seen_and_their_sum_is_kept_by_the_blur(pickups: list[Pickup]) -> None:
    learned = rates(pickups)
    assert learned.shape == (2, 24, STOPS)
    assert (learned >= 0.0).all()
    for kind in (WORKDAY, FREE_DAY):
        for stop in range(STOPS):
            seen = sum(p.stop == stop and kind_of(p.day) == kind for p in pickups)
            assert learned[kind, :, stop].sum() <= seen + 1e-9
            assert (learned[kind, :, stop].sum() > 0.0) == (seen > 0)


@given(PICKUPS, st.randoms(use_true_random=False))
def test_the_order_of_what_was_seen_does_not_matter(pickups: list[Pickup], chance: object) -> None:
    shuffled = list(pickups)
    chance.shuffle(shuffled)  # type: ignore[attr-defined]
    assert np.allclose(rates(pickups), rates(shuffled))


def test_without_a_past_nothing_is_expected_and_today_teaches_nothing_yet() -> None:
    assert not rates([]).any()
    assert not rates([Pickup(1, TODAY, 8)] * 50).any()


def test_weeks_of_the_same_morning_teach_its_rate_and_a_single_day_only_a_part_of_it() -> None:
    weeks, one = rates(every_workday(8, 4)), rates([Pickup(1, TODAY - timedelta(days=3), 8)] * 4)
    assert weeks[WORKDAY, 8, 1] == pytest.approx(0.5 * 4.0, rel=0.15)
    assert weeks[WORKDAY, 9, 1] == pytest.approx(0.25 * 4.0, rel=0.15)
    assert weeks[WORKDAY, :, 1].sum() == pytest.approx(4.0, rel=0.15)
    assert not weeks[FREE_DAY].any()
    assert 0.0 < one[WORKDAY, :, 1].sum() < 2.0


def test_what_was_long_ago_counts_less() -> None:
    changed = [*every_workday(8, 4, stop=0)[80:], *every_workday(4, 4, stop=2)]
    learned = rates(changed)
    assert learned[WORKDAY, 8, 2] > 1.5 * learned[WORKDAY, 8, 0]


WAYS = arrays(np.float64, (6, 4), elements=st.floats(0.0, 1000.0))
MOVES_MAX = 1000
RATES = arrays(np.float64, 4, elements=st.floats(0.0, 5.0))


@given(ways_s=WAYS, expected=RATES, count=st.integers(1, 4), gain_s=st.floats(1.0, 200.0))
def test_moves_end_and_each_is_worth_its_gain(
    ways_s: Array, expected: Array, count: int, gain_s: float
) -> None:
    at = list(range(count))
    wait_s = first_s = mean_wait_s(at, ways_s, expected)
    moves = 0
    for _ in range(MOVES_MAX):
        free = [place for place in range(6) if place not in at]
        move = best_move(at, free, ways_s, expected, gain_s)
        if move is None:
            break
        assert move.place in free
        at[move.vehicle] = move.place
        now_s = mean_wait_s(at, ways_s, expected)
        assert wait_s - now_s == pytest.approx(move.gain_s)
        assert move.gain_s >= gain_s
        wait_s, moves = now_s, moves + 1
    assert moves < MOVES_MAX, "vehicles are moved for ever"
    assert moves * gain_s <= first_s + 1e-6
    assert len(set(at)) == count


@given(ways_s=WAYS, expected=RATES, count=st.integers(1, 4))
def test_where_any_gain_will_do_vehicles_come_to_the_best_places_or_to_where_no_single_move_helps(
    ways_s: Array, expected: Array, count: int
) -> None:
    at = list(range(count))
    for _ in range(MOVES_MAX):
        move = best_move(at, [p for p in range(6) if p not in at], ways_s, expected, 1e-6)
        if move is None:
            break
        at[move.vehicle] = move.place
    else:
        raise AssertionError("vehicles are moved for ever")
    best_s = min(mean_wait_s(chosen, ways_s, expected) for chosen in combinations(range(6), count))
    if count == 1:
        assert mean_wait_s(at, ways_s, expected) == pytest.approx(best_s, abs=1e-5)
    else:
        assert mean_wait_s(at, ways_s, expected) >= best_s - 1e-9


def test_a_large_fleet_is_spread_over_its_stops() -> None:
    ways_s = np.abs(np.subtract.outer(np.arange(40.0), np.arange(40.0))) * 30.0
    at, expected = list(range(10)), np.ones(40)
    for _ in range(40):
        move = best_move(at, [p for p in range(40) if p not in at], ways_s, expected, 1.0)
        if move is None:
            break
        at[move.vehicle] = move.place
    assert mean_wait_s(at, ways_s, expected) < 0.15 * mean_wait_s(range(10), ways_s, expected)


def test_nobody_moves_where_nobody_is_expected_or_no_place_is_free() -> None:
    ways_s = np.array([[100.0], [0.0]])
    assert best_move([0], [1], ways_s, np.zeros(1), 1.0) is None
    assert best_move([0], [], ways_s, np.ones(1), 1.0) is None
    assert best_move([], [1], ways_s, np.ones(1), 1.0) is None
    assert best_move([0], [1], ways_s, np.ones(1), 101.0) is None
    found = best_move([0], [1], ways_s, np.ones(1), 100.0)
    assert found is not None
    assert (found.vehicle, found.place, found.gain_s) == (0, 1, 100.0)
