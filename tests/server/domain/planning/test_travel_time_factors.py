"""Factors by the hour: robust, careful with few legs, and without jumps at the stroke of the hour."""

from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.domain.planning.travel_time_factors import (
    AS_PLANNED,
    FACTOR_MAX,
    FACTOR_MIN,
    DrivenLeg,
    learned_from,
    travel_time_factor_at,
)

NOW = datetime(2026, 11, 23, tzinfo=UTC)


def legs(hour: int, *ratios: float) -> list[DrivenLeg]:
    return [DrivenLeg("c", "v", NOW, "a", "b", hour, 100.0, 100.0 * ratio) for ratio in ratios]


def test_without_legs_everything_is_as_planned() -> None:
    assert learned_from([], NOW).factors == AS_PLANNED.factors


def test_a_few_legs_move_the_factor_little_and_many_move_it_to_their_median() -> None:
    few, many = (learned_from(legs(8, *[2.0] * count), NOW) for count in (5, 2000))
    assert few.factors[8] == pytest.approx((5 * 2.0 + 20) / 25)
    assert many.factors[8] == pytest.approx(2.0, abs=0.02)
    assert many.legs[8] == 2000
    assert many.factors[9] == 1.0


def test_a_leg_that_stood_for_hours_moves_nothing() -> None:
    calm = learned_from(legs(8, *[1.2] * 101), NOW).factors[8]
    assert learned_from(legs(8, *[1.2] * 101, 9.0, 50.0, 0.0), NOW).factors[8] == pytest.approx(
        calm, abs=1e-3
    )


@pytest.mark.parametrize(("ratio", "counts"), [(0.09, 0), (0.11, 1), (9.9, 1), (10.1, 0)])
def test_a_leg_of_less_than_a_tenth_or_more_than_ten_times_its_time_does_not_count(
    ratio: float, counts: int
) -> None:
    assert learned_from(legs(8, ratio), NOW).legs[8] == counts


@given(st.lists(st.tuples(st.integers(0, 23), st.floats(0.0, 100.0)), max_size=60))
def test_factors_stay_within_their_limits(driven: list[tuple[int, float]]) -> None:
    found = learned_from([leg for hour, ratio in driven for leg in legs(hour, ratio)], NOW)
    assert all(FACTOR_MIN <= factor <= FACTOR_MAX for factor in found.factors)


@pytest.mark.parametrize(("ratio", "factor"), [(0.11, 0.5), (9.9, 3.0)])
def test_an_hour_counts_as_twice_as_fast_at_most_and_as_three_times_as_slow_at_most(
    ratio: float, factor: float
) -> None:
    assert learned_from(legs(8, *[ratio] * 200), NOW).factors[8] == factor


@given(st.lists(st.floats(0.5, 3.0), min_size=24, max_size=24), st.floats(0.0, 23.99))
def test_the_factor_goes_over_from_hour_to_hour(factors: list[float], hour: float) -> None:
    assert travel_time_factor_at(factors, int(hour) + 0.5) == pytest.approx(factors[int(hour)])
    assert abs(travel_time_factor_at(factors, hour) - travel_time_factor_at(factors, hour + 0.001)) <= 0.0026
    assert travel_time_factor_at(factors, 0.0) == pytest.approx(travel_time_factor_at(factors, 24.0))
