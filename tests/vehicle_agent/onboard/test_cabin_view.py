"""What passengers see of one tick."""

import msgspec
import pytest

from contract.wire.messages import CodeRefused, Command, RiderBoarded, RiderTask
from tests.contract.roads.ring_map import ring_map
from tests.vehicle_agent.mission.ring import OFFSET_NS, RingShuttle, a_visit, an_order, rest
from vehicle_agent.config import Profile
from vehicle_agent.onboard.cabin_view import CabinView, cabin_view, is_for_cabin
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.tick import tick
from vehicle_agent.signals import Inputs, Outputs
from vehicle_agent.stacks.gem import gem

ANN, BOB = RiderTask("ann", 1, "1111"), RiderTask("bob", 2, "2222")
ON, OFF = ("south", 40.0), ("north", 30.0)


@pytest.fixture(scope="module")
def outputs() -> Outputs:
    car = gem(Profile(), ring_map())
    return tick(initial_state(car), Inputs(1_000), car)[1]


@pytest.fixture
def shuttle() -> RingShuttle:
    visits = (a_visit("on", *ON, board=(ANN, BOB)), a_visit("off", *OFF, ON, alight=(ANN, BOB)), rest(OFF))
    shuttle = RingShuttle()
    shuttle.go(an_order(visits))
    return shuttle


def a_view(outputs: Outputs, shuttle: RingShuttle, has_position: bool = True) -> CabinView:
    flow = msgspec.structs.replace(
        outputs.flow, ego=msgspec.structs.replace(outputs.flow.ego, valid=has_position)
    )
    return cabin_view(msgspec.structs.replace(outputs, flow=flow), shuttle.state, True, 3.0)


def test_the_next_stops_come_with_distance_least_time_and_people(
    outputs: Outputs, shuttle: RingShuttle
) -> None:
    shuttle.run(1.0)
    view = a_view(outputs, shuttle)
    on, off = view.visits
    assert (on.visit_id, on.boarding, on.alighting) == ("on", 3, 0)
    assert (off.visit_id, off.boarding, off.alighting) == ("off", 0, 3)
    assert on.distance_m is not None
    assert off.distance_m is not None
    assert 0.0 < on.distance_m < 40.0 < off.distance_m
    assert on.least_s is not None
    assert off.least_s is not None
    # No faster than the vehicle may drive, and the stop before takes its dwell.
    assert on.least_s >= on.distance_m / 3.0 - 0.1
    assert off.least_s >= off.distance_m / 3.0 + shuttle.state.memory.open_visits()[0].dwell_s - 0.1


def test_without_a_position_distances_are_not_known(outputs: Outputs, shuttle: RingShuttle) -> None:
    view = a_view(outputs, shuttle, has_position=False)
    assert not view.has_position
    assert [(visit.distance_m, visit.least_s) for visit in view.visits] == [(None, None), (None, None)]


def test_the_screen_is_given_neither_codes_nor_rides(outputs: Outputs, shuttle: RingShuttle) -> None:
    shuttle.run_until(lambda: shuttle.state.doors.phase == "open")
    said = msgspec.structs.replace(outputs, events=(RiderBoarded("ann", "code"), CodeRefused("on")))
    view = cabin_view(said, shuttle.state, None, 3.0)
    assert view.answers == (RiderBoarded("", "code"), CodeRefused("on"))
    text = msgspec.json.encode(view).decode()
    for secret in ("ann", "bob", "1111", "2222"):
        assert f'"{secret}"' not in text


def test_the_screen_shows_an_announcement_as_long_as_it_stands(
    outputs: Outputs, shuttle: RingShuttle
) -> None:
    until_ns = shuttle.now_ns + OFFSET_NS + 5_000_000_000
    shuttle.step(Command(1, "c", "announce", "East side", text_zh="东侧", shown_until_ns=until_ns))
    shown = a_view(outputs, shuttle).shown
    assert shown is not None
    assert (shown.text, shown.text_zh) == ("East side", "东侧")
    shuttle.run(6.0)
    assert a_view(outputs, shuttle).shown is None


def test_only_what_passengers_must_learn_goes_out_at_once(outputs: Outputs) -> None:
    assert not is_for_cabin(msgspec.structs.replace(outputs, events=()))
    assert is_for_cabin(msgspec.structs.replace(outputs, events=(CodeRefused("on"),)))
    spoken = msgspec.structs.replace(outputs.hmi, announce="Doors are opening.")
    assert is_for_cabin(msgspec.structs.replace(outputs, events=(), hmi=spoken))
