"""How long a vehicle waits before it dials again."""

import random

import pytest

from vehicle_agent.link.redial import (
    AT_ONCE_WITHIN_S,
    FIRST_WAIT_S,
    LONGEST_WAIT_S,
    SHORTEST_PART,
    Redial,
)


def test_a_server_that_is_away_is_dialled_ever_less_often() -> None:
    redial = Redial(lambda: 1.0)
    waits_s = [redial.wait_s(was_welcomed=False) for _ in range(8)]
    assert waits_s[:3] == [FIRST_WAIT_S, 2.0 * FIRST_WAIT_S, 4.0 * FIRST_WAIT_S]
    assert waits_s[-1] == LONGEST_WAIT_S


def test_a_good_connection_makes_the_waits_short_again() -> None:
    redial = Redial(lambda: 1.0)
    for _ in range(5):
        redial.wait_s(was_welcomed=False)
    assert redial.wait_s(was_welcomed=True) == FIRST_WAIT_S
    assert redial.wait_s(was_welcomed=False) == FIRST_WAIT_S


def test_a_server_that_leaves_is_dialled_again_at_once() -> None:
    redial = Redial(lambda: 1.0)
    assert redial.wait_s(was_welcomed=True, retry="at_once") == AT_ONCE_WITHIN_S


def test_advice_counts_only_after_a_good_connection() -> None:
    redial = Redial(lambda: 1.0)
    redial.wait_s(was_welcomed=False, retry="at_once")
    assert redial.wait_s(was_welcomed=False, retry="at_once") == 2.0 * FIRST_WAIT_S


@pytest.mark.parametrize("was_welcomed", [True, False])
def test_waits_are_spread_and_never_longer_than_due(was_welcomed: bool) -> None:
    waits_s = [Redial(random.Random(seed).random).wait_s(was_welcomed=was_welcomed) for seed in range(50)]
    assert len(set(waits_s)) == 50
    assert all(SHORTEST_PART * FIRST_WAIT_S <= wait_s <= FIRST_WAIT_S for wait_s in waits_s)
