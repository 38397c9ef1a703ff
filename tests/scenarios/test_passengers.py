"""What passengers do besides riding along: buttons, calls for help, changing their mind, not turning up."""

import pytest

from contract.wire.messages import DoorsChanged, SeatButtonPressed
from tests.scenarios.campus_days import CampusDay


def doors_opened(day: CampusDay) -> int:
    events = [event for _, event in day.campus.vehicles["shuttle-1"].happened]
    return sum(isinstance(event, DoorsChanged) and event.open for event in events)


def screen(day: CampusDay) -> str:
    output = day.campus.world.displays["shuttle-1"].output
    return "" if output is None else output.screen


def test_a_seat_button_stops_the_shuttle_on_the_way_and_the_ride_goes_on(day: CampusDay) -> None:
    journey = day.request_ride()
    day.until_state(journey, "aboard")
    day.until(lambda: day.campus.world.truth("shuttle-1").speed_mps > 2.0)
    before = doors_opened(day)
    day.campus.world.riders.press_seat_button("shuttle-1", 2, day.campus.conductor.now_ns)
    day.until(lambda: doors_opened(day) == before + 1, timeout_s=60.0)
    pressed = [e for _, e in day.campus.vehicles["shuttle-1"].happened if isinstance(e, SeatButtonPressed)]
    assert [(event.seat, event.accepted) for event in pressed] == [(2, True)]
    assert abs(day.campus.world.truth("shuttle-1").speed_mps) < 0.01
    day.until(lambda: day.campus.world.truth("shuttle-1").speed_mps > 1.0, timeout_s=60.0)
    assert journey.state == "aboard"


def test_a_call_for_help_is_the_first_of_the_incidents(day: CampusDay) -> None:
    journey = day.request_ride()
    day.until_state(journey, "aboard")
    day.campus.call(day.passengers.call_help(journey.ride_id, "somebody is unwell"))
    incidents = day.campus.call(day.campus.operator.incidents())
    assert incidents[0]["kind"] == "help_call"
    assert "somebody is unwell" in incidents[0]["cause"]


@pytest.mark.long
def test_a_ride_that_is_cancelled_frees_the_shuttle_for_the_next(day: CampusDay) -> None:
    journey = day.request_ride()
    day.until_state(journey, "assigned")
    day.campus.call(day.passengers.cancel(journey.ride_id))
    day.until(lambda: journey.state == "cancelled")
    day.until(lambda: screen(day) == "RESTING", timeout_s=600.0)
    day.run_for(10.0)
    assert abs(day.campus.world.truth("shuttle-1").speed_mps) < 0.01
    day.until_state(day.request_ride(2), "boarding")


@pytest.mark.long
def test_whoever_does_not_turn_up_is_a_no_show_and_the_shuttle_goes_on(day: CampusDay) -> None:
    journey = day.request_ride(turns_up=False)
    day.until(lambda: journey.state == "no_show")
    after = day.request_ride(2)
    day.until_state(after, "completed")
