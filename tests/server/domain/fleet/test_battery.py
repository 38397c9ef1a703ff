import math

from hypothesis import given
from hypothesis import strategies as st

from server.domain.fleet.battery import charge_s, drive_left_s
from server.domain.rules import FleetRules

RULES = FleetRules()
LEGS = st.lists(st.tuples(st.floats(0.0, 3000.0), st.floats(0.0, 40_000.0)), max_size=8)


def lowest_level(ratio: float, legs: list[tuple[float, float]]) -> float:
    """Driven as planned, charging wherever the vehicle stands long enough to get to a charger."""
    level = lowest = ratio
    for drive_s, idle_s in legs:
        gained = max(0.0, idle_s - RULES.battery_rest_s_min) * RULES.battery_per_charge_s
        level = max(level, min(RULES.battery_full_ratio, level + gained))
        level -= drive_s * RULES.battery_per_drive_s
        lowest = min(lowest, level)
    return lowest


@given(ratio=st.floats(0.01, 1.0), legs=LEGS, home_s=st.floats(0.0, 2000.0), where=st.integers(0, 8))
def test_what_may_be_added_keeps_the_reserve_wherever_it_is_added(
    ratio: float, legs: list[tuple[float, float]], home_s: float, where: int
) -> None:
    left_s = drive_left_s(ratio, legs, home_s, RULES, charging=False)
    added_s = left_s - sum(drive_s for drive_s, _ in legs)
    assert added_s >= -1e-6
    if added_s > 1e-6:
        k = min(where, len(legs))
        longer = [*legs[:k], (added_s, 0.0), *legs[k:], (home_s, 0.0)]
        assert lowest_level(ratio, longer) >= RULES.battery_reserve_ratio - 1e-9


@given(ratio=st.floats(0.01, 1.0), legs=LEGS)
def test_a_shuttle_that_charges_gets_nothing_more_below_the_level_for_rides(
    ratio: float, legs: list[tuple[float, float]]
) -> None:
    left_s = drive_left_s(ratio, legs, 0.0, RULES, charging=True)
    driven_s = math.fsum(drive_s for drive_s, _ in legs)
    if ratio < RULES.battery_accept_ratio:
        assert math.isclose(left_s, driven_s, abs_tol=1e-6)
    else:
        assert left_s == drive_left_s(ratio, legs, 0.0, RULES, charging=False)


def test_rides_of_tomorrow_are_driven_on_what_is_charged_until_then() -> None:
    day = [(1500.0, 40_000.0), (1500.0, 8000.0), (1500.0, 8000.0), (1500.0, 8000.0), (1500.0, 8000.0)]
    without = [(drive_s, 0.0) for drive_s, _ in day]
    assert drive_left_s(0.6, day, 0.0, RULES, charging=False) > 11_000.0
    assert drive_left_s(0.6, without, 0.0, RULES, charging=False) < 7600.0


def test_the_defaults_fit_an_hour_of_driving_and_an_hour_of_charging() -> None:
    assert 0.2 < 3600.0 * RULES.battery_per_drive_s < 0.4
    assert 2700.0 < charge_s(0.25, 0.95, RULES) < 4500.0
    assert charge_s(0.9, 0.5, RULES) == 0.0
    levels = (
        RULES.battery_reserve_ratio,
        RULES.battery_charge_below_ratio,
        RULES.battery_accept_ratio,
        RULES.battery_full_ratio,
    )
    assert list(levels) == sorted(levels)
