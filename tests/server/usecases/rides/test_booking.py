"""The answer to a booking: a promise, a refusal that names its rule, or an error that says what to do."""

from dataclasses import replace
from datetime import timedelta

import pytest

from server.domain.errors import (
    BookingTooFarAhead,
    DomainError,
    IdempotencyMismatch,
    NoService,
    PartyInvalid,
    PartyTooLarge,
    RideAlreadyAboard,
    RideEnded,
    RideNotAboard,
    RideNotAssigned,
    RideUnknown,
    SameStop,
    StopUnknown,
    VehicleNotConnected,
)
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import BookRide, RideState
from server.domain.rules import FleetRules
from server.domain.service.timetable import Opening, ServiceHours
from server.usecases.planning import plans
from server.usecases.record import incidents
from server.usecases.rides import rides
from server.usecases.rides.tickets import ride_by_token
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map


def test_a_booking_is_answered_with_a_vehicle_and_a_promise(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6", 2)
    assert ride.state is RideState.ASSIGNED
    assert ride.vehicle_id in ("shuttle-1", "shuttle-2")
    assert ride.promise is not None
    now = fleet.campus.clock.now()
    assert now <= ride.promise.pickup_from <= ride.promise.pickup_to < ride.promise.arrive_by
    plan = fleet.campus.read(lambda uow: plans.plan_of(uow, ride.vehicle_id or ""))
    assert plan.ride_ids == (ride.ride_id,)
    assert plan.ordered[-1].kind == "rest"


@pytest.mark.parametrize(
    ("request_", "error"),
    [
        (BookRide("NOWHERE", "C6", party=1), StopUnknown),
        (BookRide("C6", "NOWHERE", party=1), StopUnknown),
        (BookRide("C6", "C6", party=1), SameStop),
        (BookRide("NN20", "C6", party=0), PartyInvalid),
        (BookRide("NN20", "C6", party=1, wheelchairs=2), PartyInvalid),
        (BookRide("NN20", "C6", party=7), PartyTooLarge),
    ],
)
def test_what_cannot_even_be_asked_is_an_error_and_leaves_nothing(
    fleet: FakeFleet, request_: BookRide, error: type[DomainError]
) -> None:
    with pytest.raises(error):
        fleet.campus.do(lambda uow: rides.book(uow, request_))
    assert fleet.rides() == ()


def test_a_booking_for_seven_people_says_to_split_the_party(fleet: FakeFleet) -> None:
    with pytest.raises(PartyTooLarge, match="split"):
        fleet.book("NN20", "C6", 7)


def test_a_booking_outside_hours_names_when_it_opens() -> None:
    hours = ServiceHours("Asia/Shanghai", tuple(Opening(day, 9 * 3600, 17 * 3600) for day in range(7)))
    campus = CampusUnderTest(shipped_map("snow-lion"), replace(FleetRules(), hours=hours))
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 1).start()
    with pytest.raises(NoService, match="09:00"):
        fleet.book("NN20", "C6")
    later = campus.clock.now() + timedelta(hours=2)
    assert fleet.book("NN20", "C6", earliest=later).state is RideState.ASSIGNED
    with pytest.raises(BookingTooFarAhead):
        fleet.book("NN20", "C6", earliest=campus.clock.now() + timedelta(days=30))
    campus.close()


def test_without_a_shuttle_the_ride_is_refused_and_kept(campus: CampusUnderTest) -> None:
    ride = campus.do(lambda uow: rides.book(uow, BookRide("NN20", "C6", party=1)))
    assert (ride.state, ride.reason) == (RideState.REFUSED, "no_vehicle_free")
    assert campus.read(lambda uow: rides.ride_of(uow, ride.ride_id)) == ride


@pytest.mark.parametrize(
    ("request_", "rule"),
    [
        (BookRide("NN20", "C6", party=2, wheelchairs=1), "wheelchair"),
        (BookRide("NN20", "C6", party=5), "seats"),
    ],
)
def test_a_refusal_names_the_binding_rule(campus: CampusUnderTest, request_: BookRide, rule: str) -> None:
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 1)
    fleet.shuttles[0].seats = 4
    fleet.start()
    assert campus.do(lambda uow: rides.book(uow, request_)).reason == rule


def test_a_repeated_idempotency_key_gives_the_same_ride_and_another_wish_is_refused(fleet: FakeFleet) -> None:
    first = fleet.book("NN20", "C6", idempotency_key="k")
    assert fleet.book("NN20", "C6", idempotency_key="k") == fleet.ride(first.ride_id)
    with pytest.raises(IdempotencyMismatch):
        fleet.book("NN20", "GYM", idempotency_key="k")
    assert len(fleet.rides()) == 1


def test_a_ride_is_found_by_its_code_however_it_is_written_and_by_its_link(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    spoken = f"{ride.ride_code[:3].lower()} {ride.ride_code[3:]}"
    assert fleet.campus.read(lambda uow: rides.ride_by_code(uow, spoken)) == ride
    assert fleet.campus.read(lambda uow: ride_by_token(uow, fleet.campus.secrets_of(ride).token)) == ride
    with pytest.raises(RideUnknown):
        fleet.campus.read(lambda uow: ride_by_token(uow, "guessed"))


def test_a_cancelled_ride_leaves_the_plan_and_cannot_be_cancelled_again(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    gone = fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))
    assert (gone.state, gone.reason) == (RideState.CANCELLED, "cancelled_by_passenger")
    assert all(not plan.ride_ids for plan in fleet.campus.read(lambda uow: uow.plans.all()))
    with pytest.raises(RideEnded):
        fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))


def test_taps_go_to_the_shuttle_only_when_they_can_mean_something(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    with pytest.raises(RideNotAboard):
        campus.do(lambda uow: rides.tap(uow, ride.ride_id, "alight"))
    tap = campus.do(lambda uow: rides.tap(uow, ride.ride_id, "board"))
    assert campus.read(lambda uow: uow.rides.pending_taps(ride.vehicle_id or "")) == (tap,)
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    shuttle.disconnect()
    with pytest.raises(VehicleNotConnected, match="code"):
        campus.do(lambda uow: rides.tap(uow, ride.ride_id, "board"))
    refused = campus.do(lambda uow: rides.book(uow, BookRide("NN20", "C6", party=6, wheelchairs=6)))
    with pytest.raises(RideEnded):
        campus.do(lambda uow: rides.tap(uow, refused.ride_id, "board"))
    assert RideNotAssigned.code == "ride_not_assigned"


def test_a_help_call_goes_to_the_top_of_the_incidents_and_is_kept_once(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    campus.do(lambda uow: incidents.open_incident(uow, IncidentKind.TAKEOVER, "shuttle-1", "earlier"))
    first = campus.do(lambda uow: rides.call_help(uow, ride.ride_id, "the door is stuck"))
    again = campus.do(lambda uow: rides.call_help(uow, ride.ride_id, "hello?"))
    assert again.incident_id == first.incident_id
    assert campus.read(lambda uow: uow.incidents.all_open())[0].kind is IncidentKind.HELP_CALL
    closed = campus.do(lambda uow: incidents.close(uow, first.incident_id, "ann"))
    assert closed.closed_by == "ann"
    assert campus.read(lambda uow: uow.incidents.all_open())[0].kind is IncidentKind.TAKEOVER


def test_somebody_aboard_cannot_board_again_and_completes(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    driven_fleet.run_until(lambda: driven_fleet.ride(ride.ride_id).state is RideState.ABOARD)
    with pytest.raises(RideAlreadyAboard):
        driven_fleet.campus.do(lambda uow: rides.tap(uow, ride.ride_id, "board"))
    driven_fleet.run_until_idle(2500.0)
    done = driven_fleet.ride(ride.ride_id)
    assert (done.state, done.left_early) == (RideState.COMPLETED, False)
