import math
from datetime import UTC, datetime, timedelta

from hypothesis import given
from hypothesis import strategies as st

from server.domain.fleet.battery import charge_s, charged_at, drive_left_s, is_measured
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


@given(
    ratio=st.floats(0.3, 1.0), drive_s=st.floats(0.0, 3000.0), home_s=st.floats(0.0, 1000.0),
    idle_s=st.floats(0.0, RULES.battery_rest_s_min),
)  # fmt: skip
def test_without_a_long_rest_the_level_only_falls(
    ratio: float, drive_s: float, home_s: float, idle_s: float
) -> None:
    left_s = drive_left_s(ratio, [(drive_s, idle_s)], home_s, RULES, charging=False)
    whole_s = (ratio - RULES.battery_reserve_ratio) / RULES.battery_per_drive_s - home_s
    assert math.isclose(left_s, max(drive_s, whole_s), rel_tol=1e-9, abs_tol=1e-6)


def test_a_rest_long_enough_charges_and_never_beyond_full() -> None:
    drive_s, long_s = 600.0, RULES.battery_rest_s_min + 7200.0
    left_s = drive_left_s(0.5, [(0.0, long_s), (drive_s, 0.0)], 0.0, RULES, charging=False)
    spare = (0.5 - RULES.battery_reserve_ratio) / RULES.battery_per_drive_s
    full = (RULES.battery_full_ratio - RULES.battery_reserve_ratio) / RULES.battery_per_drive_s
    assert math.isclose(left_s, drive_s + min(spare, full - drive_s), rel_tol=1e-9)
    # A battery above the level at which charging ends is not emptied by a rest.
    assert drive_left_s(1.0, [(0.0, long_s)], 0.0, RULES, charging=False) > full


def test_charging_ends_when_the_missing_charge_has_flowed() -> None:
    plugged_at = datetime(2026, 11, 23, 8, 0, tzinfo=UTC)
    missing = RULES.battery_full_ratio - 0.5
    full_at = plugged_at + timedelta(seconds=missing / RULES.battery_per_charge_s)
    assert abs(charged_at(0.5, plugged_at, RULES) - full_at) < timedelta(milliseconds=1)
    assert charged_at(1.0, plugged_at, RULES) == plugged_at


def test_a_vehicle_without_a_battery_sensor_reports_nought() -> None:
    assert (is_measured(0.0), is_measured(0.01)) == (False, True)
