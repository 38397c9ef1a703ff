"""A look for a free shuttle tells what a booking would get, and leaves no trace."""

from dataclasses import replace

import pytest
from sqlalchemy import select

from server.domain.errors import PartyTooLarge, StopUnknown
from server.domain.rides.rides import BookRide
from server.store.tables import metadata
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides.offers import RideOffer, offer_for
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet

WANTED = BookRide("NN20", "C6", 2)


def look(fleet: FakeFleet, wanted: BookRide = WANTED) -> RideOffer:
    return fleet.campus.read(lambda uow: offer_for(uow, wanted))


def rows(campus: CampusUnderTest) -> list[str]:
    with campus.engine.connect() as connection:
        return [repr(connection.execute(select(t)).all()) for t in metadata.tables.values()]


def set_in_service(fleet: FakeFleet, *, in_service: bool) -> None:
    def work(uow: UnitOfWork) -> None:
        for vehicle in uow.vehicles.all():
            uow.vehicles.save(replace(vehicle, in_service=in_service))

    fleet.campus.do(work)


def test_an_offer_is_what_a_booking_then_gets(fleet: FakeFleet) -> None:
    offer = look(fleet)
    assert offer.is_free
    ride = fleet.book("NN20", "C6", party=2)
    assert (offer.pickup_at, offer.arrival_at) == (ride.pickup_eta, ride.arrival_eta)


def test_a_look_changes_nothing(fleet: FakeFleet) -> None:
    before = rows(fleet.campus)
    look(fleet)
    assert rows(fleet.campus) == before


def test_while_no_shuttle_is_free_the_rule_is_told_and_then_the_offer_comes(fleet: FakeFleet) -> None:
    set_in_service(fleet, in_service=False)
    refused = fleet.book("NN20", "C6", party=2)
    assert look(fleet) == RideOffer(refused.reason)
    set_in_service(fleet, in_service=True)
    assert look(fleet).is_free


def test_what_is_never_possible_is_refused_as_a_booking_is(fleet: FakeFleet) -> None:
    with pytest.raises(StopUnknown):
        look(fleet, replace(WANTED, to_stop="the-moon"))
    with pytest.raises(PartyTooLarge):
        look(fleet, replace(WANTED, party=7))
