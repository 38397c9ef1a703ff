"""The fleet's numbers in the figures that riders and operators meet."""

import pytest

from server.domain.rules import FleetRules
from server.travel.walking import on_foot_s

RULES = FleetRules()


@pytest.mark.parametrize(
    ("direct_s", "at_most_s"), [(0.0, 600.0), (300.0, 900.0), (600.0, 1200.0), (900.0, 1800.0)]
)
def test_a_ride_takes_ten_minutes_longer_than_direct_at_most_and_a_long_one_twice_as_long(
    direct_s: float, at_most_s: float
) -> None:
    assert RULES.ride_s_max(direct_s) == at_most_s


@pytest.mark.parametrize(
    ("ahead_s", "reserve_s"), [(-50.0, 60.0), (0.0, 60.0), (600.0, 120.0), (1800.0, 240.0), (7200.0, 240.0)]
)
def test_a_promise_keeps_a_minute_and_a_tenth_of_the_time_until_then_for_the_road(
    ahead_s: float, reserve_s: float
) -> None:
    assert RULES.reserve_s(ahead_s, told_anew=False) == pytest.approx(reserve_s)
    assert RULES.reserve_s(ahead_s, told_anew=True) == pytest.approx(reserve_s + 300.0)


@pytest.mark.parametrize(("speed_mps", "stopping_m"), [(0.0, 0.0), (2.0, 5.5), (4.0, 16.0)])
def test_a_shuttle_is_told_of_a_new_stop_only_where_it_can_still_brake_for_it(
    speed_mps: float, stopping_m: float
) -> None:
    assert RULES.stopping_m(speed_mps) == pytest.approx(stopping_m)


def test_a_shuttle_leaves_earlier_for_a_timetable_than_for_a_ride() -> None:
    assert (RULES.early_s(timed=False), RULES.early_s(timed=True)) == (90.0, 300.0)


def test_four_hundred_metres_take_eight_minutes_on_foot() -> None:
    assert on_foot_s(RULES.walk_m_max, RULES.walk_mps) == pytest.approx(473.0, abs=1.0)
