"""Servers that share a PostgreSQL database: no deadlocks, and each one sees what the others have stored."""

from collections.abc import Callable

import pytest
from sqlalchemy import Engine, text

from server.domain.planning.plans import Plan
from server.domain.rides.rides import RideState
from server.store.engine import open_engine
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.store.concurrent_campus import ConcurrentCampus, run_concurrently
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

DEADLOCKS = "SELECT deadlocks FROM pg_stat_database WHERE datname = current_database()"


@pytest.mark.parametrize("servers", [1, 2])
def test_two_shuttles_their_dispatcher_and_their_passengers_never_deadlock(
    new_postgresql: Callable[[], str], servers: int
) -> None:
    url = new_postgresql()
    campus = ConcurrentCampus(url, servers)
    booked = run_concurrently(campus, shuttles=2, rounds=60)
    plans = campus.read(lambda uow: uow.plans.all())
    rides = campus.read(lambda uow: uow.rides.in_states([RideState.ASSIGNED]))
    campus.close()
    assert {ride.state for ride in booked} <= {RideState.ASSIGNED, RideState.REFUSED}
    for ride in rides:
        holders = [plan.vehicle_id for plan in plans if ride.ride_id in plan.ride_ids]
        assert holders == [ride.vehicle_id]
    assert deadlocks_of(url) == 0


def test_what_one_server_has_stored_the_others_read_again(engine: Engine) -> None:
    """Each one keeps the fleet in memory; the version of the campus tells that it is no longer true."""
    one = CampusUnderTest(shipped_map("snow-lion"), engine=engine)
    FakeFleet(one, one.road_map, 2).start()
    other = CampusUnderTest(shipped_map("snow-lion"), engine=open_engine(engine.url.render_as_string(False)))
    for number, (writer, reader) in enumerate([(one, other), (other, one), (one, other)], start=1):
        assert writer.do(fleet_of) == reader.do(fleet_of)

        def change(uow: UnitOfWork, number: int = number) -> None:
            plan = uow.plans.get("shuttle-1") or Plan(uow.campus_id, "shuttle-1", 0)
            moved = Plan(uow.campus_id, "shuttle-1", plan.version + 1, (), f"place-{number}")
            uow.plans.save(moved, plan.version)

        writer.do(change)
        plan = reader.do(lambda uow: uow.plans.get("shuttle-1"))
        assert plan is not None
        assert plan.resting_place_id == f"place-{number}"
        assert writer.do(fleet_of) == reader.do(fleet_of)
    other.close()
    one.close()


def test_a_transaction_that_was_rolled_back_does_not_make_the_others_read_again(engine: Engine) -> None:
    campus = CampusUnderTest(shipped_map("snow-lion"), engine=engine)
    kept = campus.do(lambda uow: uow.maps.active())

    def fails(_: UnitOfWork) -> None:
        raise LookupError

    with pytest.raises(LookupError):
        campus.do(fails)
    assert campus.do(lambda uow: uow.maps.active()) is kept
    campus.close()


def fleet_of(uow: UnitOfWork) -> object:
    return uow.vehicles.all(), uow.plans.all(), uow.sections.all(), uow.rides.in_states(list(RideState))


def deadlocks_of(url: str) -> int:
    engine = open_engine(url)
    with engine.connect() as connection:
        count = int(connection.execute(text(DEADLOCKS)).scalar_one())
    engine.dispose()
    return count
