"""A ride that was taken can be rated after its end; the newest word counts."""

from dataclasses import replace

import pytest

from server.domain.errors import RideNotCompleted
from server.domain.rides.feedback import Feedback
from server.domain.rides.rides import Ride, RideState
from server.usecases.rides.feedback import give_feedback
from tests.server.usecases.fake_fleet import FakeFleet


def ended(fleet: FakeFleet, state: RideState, *, taken: bool) -> Ride:
    now = fleet.campus.clock.now()
    ride = replace(fleet.book("NN20", "C6"), state=state, ended_at=now, boarded_at=now if taken else None)
    fleet.campus.do(lambda uow: uow.rides.save(ride))
    return ride


def test_what_is_told_again_replaces_what_was_told_before(fleet: FakeFleet) -> None:
    ride = ended(fleet, RideState.COMPLETED, taken=True)
    fleet.campus.do(lambda uow: give_feedback(uow, ride, 2, "an umbrella"))
    fleet.campus.clock.advance(60.0)
    last = fleet.campus.do(lambda uow: give_feedback(uow, ride, 4, ""))
    stored = fleet.campus.read(lambda uow: uow.rides.feedback_of([ride.ride_id, "no-ride"]))
    assert stored == {ride.ride_id: last}
    assert last == Feedback("snow-lion", ride.ride_id, 4, "", fleet.campus.clock.now())


def test_the_record_says_that_something_was_lost_and_not_what(fleet: FakeFleet) -> None:
    ride = ended(fleet, RideState.FAILED, taken=True)
    fleet.campus.do(lambda uow: give_feedback(uow, ride, 5, "an umbrella"))
    newest = fleet.campus.read(lambda uow: uow.views.server_events(1))[0]
    assert (newest.name, newest.subject, newest.detail) == (
        "ride.feedback",
        ride.ride_id,
        "rated 5 of 5, lost property",
    )


@pytest.mark.parametrize("state", [RideState.CANCELLED, RideState.NO_SHOW, RideState.REFUSED])
def test_a_ride_that_nobody_took_cannot_be_rated(fleet: FakeFleet, state: RideState) -> None:
    ride = ended(fleet, state, taken=False)
    with pytest.raises(RideNotCompleted):
        fleet.campus.do(lambda uow: give_feedback(uow, ride, 5, ""))


def test_a_ride_that_goes_on_cannot_be_rated(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    with pytest.raises(RideNotCompleted):
        fleet.campus.do(lambda uow: give_feedback(uow, ride, 5, ""))
