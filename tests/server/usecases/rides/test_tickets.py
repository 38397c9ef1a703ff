"""Links and codes over a change of keys: what passengers hold works on, and shuttles know the codes."""

from dataclasses import replace

import pytest
from sqlalchemy import select

from server.domain.errors import RideUnknown, SeriesUnknown, TicketKeyMissing
from server.domain.rides.rides import Ride, RideState
from server.domain.rides.ticket_keys import TicketKeys
from server.store import tables
from server.store.rides.rides import SqlRideRepository
from server.usecases.orders.outbox import outbox_of
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.identity import sha256_of
from server.usecases.rides.tickets import ride_by_token, secrets_of, series_by_token, take_over_keys
from tests.server.usecases.campus_under_test import TICKET_KEYS, CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet

OTHER_KEY = bytes(range(7, 39))
OLD_LINK = "q3Jv0X2mQp7sT4uYb1cD9wq3Jv0X2mQp"


def with_keys(keys: TicketKeys):  # type: ignore[no-untyped-def]
    """`take_over_keys` of a server that has these keys."""

    def work(uow: UnitOfWork) -> None:
        uow.tickets = keys
        take_over_keys(uow)

    return work


def as_of_before_keys(campus: CampusUnderTest, ride: Ride) -> None:
    """The ride as the migration leaves one that was booked before there were keys."""

    def work(uow: UnitOfWork) -> None:
        assert isinstance(uow.rides, SqlRideRepository)
        uow.rides.save(replace(ride, ticket_key_id=""))
        uow.rides.flush()
        is_it = tables.rides.c.ride_id == ride.ride_id
        uow.rides._update(tables.rides, {"old_token_sha256": sha256_of(OLD_LINK)}, is_it)

    campus.do(work)


def test_no_row_holds_a_token_or_code_that_the_shuttle_is_sent(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    secrets = campus.secrets_of(ride)
    order = campus.read(lambda uow: outbox_of(uow, ride.vehicle_id or "")).order
    assert order is not None
    assert order.visits[0].board[0].code == secrets.boarding_code
    with campus.engine.connect() as connection:
        rows = repr(connection.execute(select(tables.rides)).all())
        payloads = repr(connection.execute(select(tables.orders.c.payload)).all())
    assert secrets.token[:24] not in rows
    assert f"'{secrets.boarding_code}'" not in rows
    assert f'"{secrets.boarding_code}"' not in payloads


def test_links_of_unknown_rides_and_series_are_refused(campus: CampusUnderTest) -> None:
    for token in ("", "guessed", OLD_LINK, f"{'A' * 24}ride-1"):
        with pytest.raises(RideUnknown):
            campus.read(lambda uow, token=token: ride_by_token(uow, token))  # type: ignore[misc]
        with pytest.raises(SeriesUnknown):
            campus.read(lambda uow, token=token: series_by_token(uow, token))  # type: ignore[misc]


def test_a_link_of_before_there_were_keys_works_on_and_so_does_the_new_one(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    as_of_before_keys(campus, ride)
    assert campus.read(lambda uow: ride_by_token(uow, OLD_LINK)).ride_id == ride.ride_id
    campus.do(take_over_keys)
    found = campus.read(lambda uow: ride_by_token(uow, OLD_LINK))
    assert found.ticket_key_id == TICKET_KEYS.newest_id
    new_link = campus.secrets_of(found).token
    assert campus.read(lambda uow: ride_by_token(uow, new_link)) == found


def test_shuttles_are_told_the_new_codes_of_rides_of_before_there_were_keys(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    vehicle_id = ride.vehicle_id or ""
    fleet.run_until(lambda: campus.read(lambda uow: outbox_of(uow, vehicle_id)).order is None, 60.0)
    as_of_before_keys(campus, ride)
    campus.do(take_over_keys)
    order = campus.read(lambda uow: outbox_of(uow, vehicle_id)).order
    assert order is not None
    assert order.visits[0].board[0].code == campus.secrets_of(fleet.ride(ride.ride_id)).boarding_code


def test_ended_rides_of_before_there_were_keys_get_one_too(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    as_of_before_keys(campus, replace(ride, state=RideState.COMPLETED))
    campus.do(take_over_keys)
    assert fleet.ride(ride.ride_id).ticket_key_id == TICKET_KEYS.newest_id


def test_after_a_rotation_old_links_work_and_new_rides_have_the_new_key(fleet: FakeFleet) -> None:
    campus = fleet.campus
    campus.do(take_over_keys)
    before = fleet.book("NN20", "C6")
    link = campus.secrets_of(before).token
    both = TicketKeys([OTHER_KEY, bytes(range(32))])
    campus.do(with_keys(both))

    def found(uow: UnitOfWork) -> str:
        uow.tickets = both
        return secrets_of(uow, ride_by_token(uow, link)).token

    assert campus.read(found) == link
    names = [event.name for event in campus.read(lambda uow: uow.views.server_events())]
    assert names.count("ticket_key.added") == 2


def test_a_server_with_other_keys_than_the_campus_refuses_to_start(campus: CampusUnderTest) -> None:
    campus.do(take_over_keys)
    with pytest.raises(TicketKeyMissing, match="copy of the file"):
        campus.do(with_keys(TicketKeys([OTHER_KEY])))


def test_a_key_that_open_rides_were_made_with_cannot_be_taken_away(fleet: FakeFleet) -> None:
    campus = fleet.campus
    campus.do(take_over_keys)
    campus.do(with_keys(TicketKeys([OTHER_KEY, bytes(range(32))])))
    fleet.book("NN20", "C6")
    with pytest.raises(TicketKeyMissing, match="until they have ended"):
        campus.do(with_keys(TicketKeys([OTHER_KEY])))
