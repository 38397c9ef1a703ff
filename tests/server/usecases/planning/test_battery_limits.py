"""What a battery allows: its plan drives, and charges where the vehicle stands for long enough."""

from dataclasses import replace

import numpy as np
import pytest

from contract.geometry import Array
from server.dispatch.problem import Call, Request, VehicleState
from server.usecases.planning.battery_limits import ChargeLimits, within_battery
from tests.server.usecases.campus_under_test import CampusUnderTest

RATIO, FIRST_DRIVE_S, SECOND_DRIVE_S, DWELL_S = 0.5, 100.0, 4000.0, 600.0
TIMES: Array = np.array([[0.0, SECOND_DRIVE_S], [SECOND_DRIVE_S, 0.0]])
WAITS_FOR_NOBODY = VehicleState(
    "shuttle-1",
    np.array([FIRST_DRIVE_S, 50.0]),
    ready_s=1000.0,
    seats=6,
    wheelchair_places=0,
    calls=(Call(0, dwell_s=DWELL_S), Call(1, board=("ride-1",), dwell_s=15.0)),
)


def a_ride(pickup_from_s: float) -> dict[str, Request]:
    return {"ride-1": Request("ride-1", 1, 0, 1, 0, pickup_from_s, pickup_from_s + 600.0, 1e6)}


def allowed_s(campus: CampusUnderTest, vehicle: VehicleState, rides: dict[str, Request]) -> float:
    """Seconds of driving, the way to a charger added again."""
    limits = ChargeLimits(RATIO, charging=False)
    return campus.read(
        lambda uow: (
            within_battery(uow, vehicle, limits, rides, TIMES).drive_s_max + uow.roads().to_charger_s()
        )
    )


def test_without_rest_all_that_is_above_the_reserve_is_for_driving(campus: CampusUnderTest) -> None:
    rules = campus.rules
    above_s = (RATIO - rules.battery_reserve_ratio) / rules.battery_per_drive_s
    assert allowed_s(campus, WAITS_FOR_NOBODY, a_ride(0.0)) == pytest.approx(above_s)


@pytest.mark.parametrize("rest_s", [1000.0, 2000.0])
def test_a_rest_before_a_late_ride_charges_for_as_long_as_it_lasts(
    campus: CampusUnderTest, rest_s: float
) -> None:
    """The rest begins when the vehicle has left the first stop and come to the second one."""
    rules = campus.rules
    comes_s = 1000.0 + FIRST_DRIVE_S + DWELL_S + SECOND_DRIVE_S
    rides = a_ride(comes_s + rules.battery_rest_s_min + rest_s)
    before = RATIO - FIRST_DRIVE_S * rules.battery_per_drive_s
    after = min(before + rest_s * rules.battery_per_charge_s, rules.battery_full_ratio)
    after -= SECOND_DRIVE_S * rules.battery_per_drive_s
    spare_s = (min(before, after) - rules.battery_reserve_ratio) / rules.battery_per_drive_s
    assert allowed_s(campus, WAITS_FOR_NOBODY, rides) == pytest.approx(
        FIRST_DRIVE_S + SECOND_DRIVE_S + spare_s
    )


def test_a_timetable_call_is_rested_for_until_it_leaves(campus: CampusUnderTest) -> None:
    rules = campus.rules
    comes_s = 1000.0 + FIRST_DRIVE_S + DWELL_S + SECOND_DRIVE_S
    leaves_s = comes_s + rules.battery_rest_s_min + 1000.0 + 15.0
    timetable = replace(
        WAITS_FOR_NOBODY,
        calls=(WAITS_FOR_NOBODY.calls[0], Call(1, dwell_s=15.0, leave_from_s=leaves_s, fixed=True)),
    )
    ride = a_ride(comes_s + rules.battery_rest_s_min + 1000.0)
    assert allowed_s(campus, timetable, {}) == pytest.approx(allowed_s(campus, WAITS_FOR_NOBODY, ride))


def test_a_battery_that_nobody_measures_is_no_limit(campus: CampusUnderTest) -> None:
    unmeasured = ChargeLimits(0.0, charging=False)
    limited = campus.read(lambda uow: within_battery(uow, WAITS_FOR_NOBODY, unmeasured, a_ride(0.0), TIMES))
    assert limited is WAITS_FOR_NOBODY
