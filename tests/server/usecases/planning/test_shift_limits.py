"""What a vehicle's shifts leave of its calls: breaks between them, its end, and when it takes nothing new."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from zoneinfo import ZoneInfo

import numpy as np
import pytest

from contract.geometry import Array
from server.dispatch.problem import Call, VehicleState
from server.domain.fleet.shifts import Shift, Shifts
from server.usecases.planning.shift_limits import with_shifts
from tests.server.usecases.campus_under_test import MORNING
from tests.server.usecases.fake_fleet import FakeFleet

ZONE = ZoneInfo("Asia/Shanghai")
# The clock of the tests begins at 08:00 there.
MIDNIGHT = MORNING.astimezone(ZONE).replace(hour=0)
LONG_AGO = MIDNIGHT - timedelta(days=9)


def at(hours: float) -> datetime:
    return MIDNIGHT + timedelta(hours=hours)


def daily(*hours: tuple[float, float]) -> Shifts:
    return Shifts((tuple(Shift(int(begins * 3600), int(ends * 3600)) for begins, ends in hours),) * 7)


def free(to_places_s: Array | None = None) -> VehicleState:
    ways = np.array([90.0, 30.0, 60.0]) if to_places_s is None else to_places_s
    return VehicleState("shuttle-1", ways, MORNING.timestamp(), 6, 1)


def limited(
    fleet: FakeFleet,
    shifts: Shifts,
    state: VehicleState,
    planned: Sequence[datetime] = (),
    until: datetime = LONG_AGO,
) -> VehicleState:
    return fleet.campus.read(lambda uow: with_shifts(uow, shifts, state, planned, until))


def home_s(fleet: FakeFleet) -> float:
    found = fleet.campus.read(lambda uow: uow.roads().way_home_s())
    assert found > 0.0
    return found


BUSY = {
    "a rider aboard": (replace(free(), aboard=("ride",)), ()),
    "standing at a stop": (replace(free(), calls=(Call(1),), locked=1), (at(10),)),
    "a call before its shift": (replace(free(), calls=(Call(1), Call(2))), (at(8.1), at(10.5))),
}


@pytest.mark.parametrize("reason", BUSY)
def test_who_has_to_finish_before_its_shift_takes_nothing_new(fleet: FakeFleet, reason: str) -> None:
    state, planned = BUSY[reason]
    assert limited(fleet, daily((10, 12)), state, planned) == replace(state, accepts=False)


def test_a_call_planned_for_the_beginning_of_its_shift_keeps_nobody_from_its_next_rides(
    fleet: FakeFleet,
) -> None:
    state = replace(free(), calls=(Call(1),))
    found = limited(fleet, daily((10, 12)), state, (at(10),))
    assert found.accepts
    assert found.calls == state.calls
    assert found.ready_s == at(10).timestamp()


def test_who_is_on_duty_from_this_moment_takes_new_rides_with_riders_aboard(fleet: FakeFleet) -> None:
    state = replace(free(), aboard=("ride",))
    assert limited(fleet, daily((8, 12)), state).accepts


def test_who_is_never_on_duty_takes_nothing(fleet: FakeFleet) -> None:
    assert not limited(fleet, daily(), free()).accepts


def test_off_duty_only_the_next_shift_counts_when_nothing_later_is_asked_for(fleet: FakeFleet) -> None:
    found = limited(fleet, daily((10, 12), (13, 15)), free())
    assert found.calls == ()
    assert found.on_duty_to_s - at(12).timestamp() == pytest.approx(-home_s(fleet))


def test_the_shifts_up_to_a_later_call_count_and_no_others(fleet: FakeFleet) -> None:
    state = replace(free(), calls=(Call(2),))
    found = limited(fleet, daily((7, 9), (10, 12), (13, 15)), state, (at(11),))
    assert [call.off_duty for call in found.calls] == [True, False]
    assert found.on_duty_to_s - at(12).timestamp() == pytest.approx(-home_s(fleet))


def test_the_way_home_takes_as_long_as_driving_takes_now(fleet: FakeFleet) -> None:
    found = fleet.campus.read(
        lambda uow: with_shifts(_Slow(uow, 2.0), daily((7, 12)), free(), (), LONG_AGO)  # type: ignore[arg-type]
    )
    assert found.on_duty_to_s - at(12).timestamp() == pytest.approx(-2.0 * home_s(fleet))


class _Slow:
    """A unit of work for which driving takes `factor` times as long."""

    def __init__(self, uow: object, factor: float) -> None:
        self._uow, self._factor = uow, factor

    def __getattr__(self, name: str) -> object:
        return getattr(self._uow, name)

    def travel_time_factor_at(self, _when: datetime) -> float:
        return self._factor


def test_a_break_before_the_first_call_is_spent_at_the_nearest_stop_and_the_way_there_follows_it(
    fleet: FakeFleet,
) -> None:
    found = limited(fleet, daily((7, 9), (10, 12)), free(), until=at(11))
    (off,) = found.calls
    assert off.place == 1
    assert off.leave_from_s == at(10).timestamp() + 30.0
    assert off.arrive_by_s - at(9).timestamp() == pytest.approx(-home_s(fleet))
    assert off.leave_from_s - off.arrive_by_s == pytest.approx(off.dwell_s)


def test_a_break_of_a_vehicle_that_reaches_no_stop_ends_with_its_shift(fleet: FakeFleet) -> None:
    found = limited(fleet, daily((7, 9), (10, 12)), free(np.full(3, np.inf)), until=at(11))
    assert [call.leave_from_s for call in found.calls] == [at(10).timestamp()]


def test_breaks_lie_between_the_calls_of_the_shifts_around_them(fleet: FakeFleet) -> None:
    state = replace(free(), calls=(Call(0), Call(2), Call(1)))
    found = limited(fleet, daily((7, 9), (10, 12), (13, 15)), state, (at(8.5), at(10), at(14)))
    assert [call.call_id for call in found.calls] == ["", "off-duty-0", "", "off-duty-1", ""]
    assert [call.place for call in found.calls] == [0, 0, 2, 2, 1]
    assert [call.leave_from_s for call in found.calls if call.off_duty] == [
        at(10).timestamp(),
        at(13).timestamp(),
    ]


def test_a_call_far_ahead_is_kept_behind_the_last_break_that_is_reckoned(fleet: FakeFleet) -> None:
    state = replace(free(), calls=(Call(2),))
    found = limited(fleet, daily((7, 12)), state, (at(24 * 200),))
    assert all(call.off_duty for call in found.calls[:-1])
    assert len(found.calls) < 20
    assert found.calls[-1] == Call(2)
