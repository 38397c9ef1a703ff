"""The server's clock as the vehicle knows it."""

import pytest

from vehicle_agent.link.clock import ClockOffset

S = 1_000_000_000


def test_the_welcome_gives_a_first_value_and_forgets_the_connection_before() -> None:
    clock = ClockOffset()
    clock.add(0, 500, 2)
    clock.restart(7 * S, 2 * S)
    assert clock.offset_ns == 5 * S
    clock.add(10 * S, 25 * S, 12 * S)
    assert clock.offset_ns == 14 * S, "the shorter round trip of the connection before does not count"


def test_an_answer_lies_half_way_between_question_and_arrival() -> None:
    clock = ClockOffset()
    clock.add(1 * S, 101 * S, 3 * S)
    assert clock.offset_ns == 99 * S


def test_a_short_round_trip_counts_until_eight_others_have_come() -> None:
    clock = ClockOffset()
    clock.add(0, 1_000, 10)
    for number in range(7):
        clock.add(number * S, number * S + 2_000, number * S + 100)
    assert clock.offset_ns == 995
    clock.add(8 * S, 8 * S + 2_000, 8 * S + 100)
    assert clock.offset_ns == 1_950


def test_an_answer_before_its_question_is_a_mistake_and_one_at_once_is_none() -> None:
    clock = ClockOffset()
    with pytest.raises(ValueError, match="before its request"):
        clock.add(5, 100, 4)
    clock.add(5, 100, 5)
    assert clock.offset_ns == 95
