"""What names a rider can be erased, at once and by itself; the history can still be counted."""

from datetime import timedelta

import pytest
from sqlalchemy import select

from server.domain.errors import RideNotEnded, RideUnknown, SeriesUnknown
from server.domain.record.incidents import ERASED_CAUSE, IncidentKind
from server.domain.rides.rides import Ride, RideState
from server.domain.rides.series import BookSeries
from server.loops.retention import RetentionLoop
from server.loops.series import SeriesScheduler
from server.store.tables import metadata
from server.usecases.rides import erasure, rides, series
from server.usecases.rides.feedback import give_feedback
from server.usecases.rides.tickets import ride_by_token
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet

MESSAGE = "Ms Wang of room 12 cannot open the door"


def everything_stored(campus: CampusUnderTest) -> str:
    with campus.engine.connect() as connection:
        return "\n".join(repr(connection.execute(select(t)).all()) for t in metadata.tables.values())


def a_ride_with_a_call_for_help(fleet: FakeFleet) -> Ride:
    ride = fleet.book("NN20", "C6", idempotency_key="the-key-of-the-booking")
    fleet.campus.do(lambda uow: rides.call_help(uow, ride.ride_id, MESSAGE))
    fleet.campus.do(lambda uow: rides.tap(uow, ride.ride_id, "board"))
    return fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))


def booked_series(fleet: FakeFleet) -> tuple[str, Ride]:
    request = BookSeries(
        "NN20", "C6", (0, 1), 8 * 3600 + 1800, fleet.campus.clock.now().date() + timedelta(days=1), 1, 0
    )
    made = fleet.campus.do(lambda uow: series.book_series(uow, request))
    fleet.campus.wait_for(SeriesScheduler(fleet.campus.transactions, "me").run_once())
    (ride,) = fleet.rides()
    return made.series_id, ride


def test_an_erased_ride_is_still_counted_and_nothing_stored_names_its_rider(fleet: FakeFleet) -> None:
    campus, ride = fleet.campus, a_ride_with_a_call_for_help(fleet)
    campus.do(lambda uow: erasure.erase_ride(uow, ride.ride_id, "ann"))
    kept = fleet.ride(ride.ride_id)
    same = ("state", "from_stop", "to_stop", "party", "requested_at", "ended_at", "promise", "vehicle_id")
    assert [getattr(kept, name) for name in same] == [getattr(ride, name) for name in same]
    stored = everything_stored(campus)
    for name in (MESSAGE, ride.ride_code, "the-key-of-the-booking", ride.ticket_key_id):
        assert name not in stored


def test_what_a_passenger_said_after_the_ride_is_erased_with_the_rider(driven_fleet: FakeFleet) -> None:
    campus, ride = driven_fleet.campus, driven_fleet.book("NN20", "C6")
    driven_fleet.run_until(lambda: driven_fleet.ride(ride.ride_id).has_ended)
    taken = driven_fleet.ride(ride.ride_id)
    assert taken.state is RideState.COMPLETED
    campus.do(lambda uow: give_feedback(uow, taken, 2, MESSAGE))
    assert MESSAGE in everything_stored(campus)
    campus.do(lambda uow: erasure.erase_ride(uow, ride.ride_id, "ann"))
    assert MESSAGE not in everything_stored(campus)
    assert campus.read(lambda uow: uow.rides.feedback_of([ride.ride_id])) == {}


def test_the_erasure_is_an_event_with_the_operators_name(fleet: FakeFleet) -> None:
    campus, ride = fleet.campus, a_ride_with_a_call_for_help(fleet)
    campus.do(lambda uow: erasure.erase_ride(uow, ride.ride_id, "ann"))
    newest = campus.read(lambda uow: uow.views.server_events(1))[0]
    assert (newest.name, newest.subject, newest.by) == ("ride.erased", ride.ride_id, "ann")


def test_the_link_and_the_code_of_an_erased_ride_lead_nowhere(fleet: FakeFleet) -> None:
    campus, ride = fleet.campus, a_ride_with_a_call_for_help(fleet)
    link = campus.secrets_of(ride).token
    campus.do(lambda uow: erasure.erase_ride(uow, ride.ride_id, "ann"))
    with pytest.raises(RideUnknown):
        campus.read(lambda uow: ride_by_token(uow, link))
    with pytest.raises(RideUnknown):
        campus.read(lambda uow: rides.ride_by_code(uow, ride.ride_code))
    assert campus.secrets_of(fleet.ride(ride.ride_id)).boarding_code == ""


def test_an_open_incident_of_an_erased_ride_stays_open_without_its_words(fleet: FakeFleet) -> None:
    campus, ride = fleet.campus, a_ride_with_a_call_for_help(fleet)
    campus.do(lambda uow: erasure.erase_ride(uow, ride.ride_id, "ann"))
    for look in (campus.do, campus.read):
        found = look(lambda uow: uow.incidents.open_about(IncidentKind.HELP_CALL, ride.ride_id))
        assert found is not None
        assert found.cause == ERASED_CAUSE


def test_a_ride_that_goes_on_is_not_erased(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    with pytest.raises(RideNotEnded, match="cancel it"):
        fleet.campus.do(lambda uow: erasure.erase_ride(uow, ride.ride_id, "ann"))
    assert fleet.ride(ride.ride_id) == ride


def test_a_series_is_erased_with_the_riders_of_its_days(fleet: FakeFleet) -> None:
    campus = fleet.campus
    series_id, ride = booked_series(fleet)
    assert campus.do(lambda uow: erasure.erase_series(uow, series_id, "ann")) == 1
    with pytest.raises(SeriesUnknown):
        campus.read(lambda uow: series.series_of(uow, series_id))
    kept = fleet.ride(ride.ride_id)
    assert (kept.state, kept.ride_code, kept.series_id) == (RideState.CANCELLED, "", None)
    assert campus.read(lambda uow: uow.series.occurrences(series_id)) == ()


def test_retention_erases_riders_after_their_days_and_not_before(fleet: FakeFleet) -> None:
    campus, ride = fleet.campus, a_ride_with_a_call_for_help(fleet)
    days = timedelta(days=campus.rules.rider_days)
    campus.clock.advance(days.total_seconds() - 60.0)
    campus.wait_for(RetentionLoop(campus.transactions).run_once())
    assert fleet.ride(ride.ride_id).ride_code == ride.ride_code
    campus.clock.advance(120.0)
    campus.wait_for(RetentionLoop(campus.transactions).run_once())
    assert fleet.ride(ride.ride_id).ride_code == ""
    assert MESSAGE not in everything_stored(campus)


def test_retention_drops_ended_series_and_keeps_those_that_go_on(fleet: FakeFleet) -> None:
    campus = fleet.campus
    gone, ride = booked_series(fleet)
    campus.do(lambda uow: series.cancel_series(uow, gone, "passenger"))
    last = campus.clock.now().date() + timedelta(days=200)
    request = BookSeries("NN20", "C6", (0, 1), 8 * 3600, last, 1, 0)
    kept = campus.do(lambda uow: series.book_series(uow, request))
    campus.clock.advance(timedelta(days=campus.rules.rider_days + 1).total_seconds())
    campus.wait_for(RetentionLoop(campus.transactions).run_once())
    assert [one.series_id for one in campus.read(lambda uow: uow.series.listed())] == [kept.series_id]
    assert fleet.ride(ride.ride_id).series_id is None


def test_retention_erases_each_rider_once(fleet: FakeFleet) -> None:
    campus = fleet.campus
    a_ride_with_a_call_for_help(fleet)
    campus.clock.advance(timedelta(days=campus.rules.rider_days + 1).total_seconds())
    for _ in range(2):
        campus.wait_for(RetentionLoop(campus.transactions).run_once())
    names = [event.name for event in campus.read(lambda uow: uow.views.server_events())]
    assert names.count("riders.erased") == 1
