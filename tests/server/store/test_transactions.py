"""One use case, one transaction: all or nothing, messages after the commit, conflicts decided again."""

import asyncio
import gc
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, text
from sqlalchemy.exc import DBAPIError
from structlog.contextvars import bound_contextvars, get_contextvars

from contract.roads.load import encode_map
from server.adapters import SeededIds
from server.bus.in_process import InProcessBus, LocalSubscription
from server.domain.errors import PlanChanged, StoreUnavailable, VehicleUnknown
from server.domain.planning.plans import Plan
from server.domain.record.incidents import IncidentKind
from server.domain.rides.effects import Effects, Intervention
from server.domain.rides.rides import BookRide, RideState
from server.domain.rules import FleetRules
from server.store.engine import open_engine, read_only
from server.store.roads.map_library import MapLibrary
from server.store.transactions import GroupCommit, InlineTransactions
from server.store.unit_of_work import Context
from server.store.writing.retries import NO_RETRIES
from server.store.writing.writer import ATTEMPTS
from server.usecases.fleet import campus
from server.usecases.fleet.interventions import intervene
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import commands, incidents
from server.usecases.record.dry_run import roll_back
from server.usecases.rides import rides
from tests.full_disk import full_disk
from tests.server.conftest import CLOSE_OTHERS
from tests.server.usecases.campus_under_test import TICKET_KEYS, CampusUnderTest, HandClock, PlainHasher
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fresh_database import write_fresh_database
from tests.server.usecases.shipped_maps import shipped_map


class NamedIds(SeededIds):
    """Ids that no other transactions on the same database have made."""

    def new_id(self, kind: str) -> str:
        return f"live-{super().new_id(kind)}"


@asynccontextmanager
async def live(engine: Engine, seed: int = 7) -> AsyncIterator[tuple[GroupCommit, LocalSubscription]]:
    """The live transactions of this database, without retries, and all that is published."""
    rules = FleetRules()
    context = Context(
        "snow-lion", HandClock(), NamedIds(seed), rules, PlainHasher(), MapLibrary(rules), TICKET_KEYS
    )
    bus = InProcessBus()
    heard = await bus.subscribe("campus/>")
    transactions = GroupCommit(engine, context, bus, NO_RETRIES)
    yield transactions, heard
    await transactions.close()


def opened(name: str) -> Callable[[UnitOfWork], str]:
    def work(uow: UnitOfWork) -> str:
        return incidents.open_incident(uow, IncidentKind.TAKEOVER, name, "test").incident_id

    return work


def count_open(uow: UnitOfWork) -> int:
    return len(uow.views.incidents())


def test_connections_that_the_database_has_closed_are_replaced(new_postgresql: Callable[[], str]) -> None:
    """As after a restart of PostgreSQL, or a firewall that forgets idle connections."""
    url = new_postgresql()
    engine, other = open_engine(url), open_engine(url)

    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            assert await transactions.read(count_open) == 0
            with other.begin() as connection:
                connection.execute(text(CLOSE_OTHERS))
            assert await transactions.read(count_open) == 0

    asyncio.run(scenario())
    other.dispose()


def test_a_process_that_fails_while_its_store_is_open_ends(tmp_path: Path) -> None:
    write_fresh_database(tmp_path / "campusloop.db")
    program = """import sys
from server.store.engine import open_engine, read_only
from server.store.transactions import GroupCommit
transactions = GroupCommit(open_engine(sys.argv[1]), None, None)
raise RuntimeError("before it was closed")"""
    command = [sys.executable, "-c", program, f"sqlite:///{tmp_path}/campusloop.db"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1
    assert "before it was closed" in ended.stderr


def test_many_use_cases_at_once_are_all_stored(engine: Engine) -> None:
    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            ids = await asyncio.gather(*(transactions.run(opened(f"v{k}")) for k in range(40)))
            assert len(set(ids)) == 40
            assert await transactions.read(count_open) == 40

    asyncio.run(scenario())


def test_one_that_fails_takes_nothing_with_it_and_says_nothing(engine: Engine) -> None:
    def fails(uow: UnitOfWork) -> None:
        opened("lost")(uow)
        commands.send_command(uow, "ghost", "hold", "test")

    async def scenario() -> None:
        async with live(engine) as (transactions, heard):
            results = await asyncio.gather(
                transactions.run(opened("one")),
                transactions.run(fails),
                transactions.run(opened("two")),
                return_exceptions=True,
            )
            assert isinstance(results[1], VehicleUnknown)
            assert await transactions.read(count_open) == 2
            topics = [(await anext(heard))[1] for _ in range(2)]
            assert all(b"takeover" in payload for payload in topics)

    asyncio.run(scenario())


def test_a_caller_that_gives_up_does_not_undo_what_it_asked_for(engine: Engine) -> None:
    async def scenario() -> None:
        async with live(engine) as (transactions, heard):
            task = asyncio.create_task(transactions.run(opened("one")))
            await asyncio.sleep(0)
            task.cancel()
            await transactions.run(opened("two"))
            payloads = {(await asyncio.wait_for(anext(heard), 5.0))[1] for _ in range(2)}
            assert len(payloads) == 2
            assert await transactions.read(count_open) == 2

    asyncio.run(scenario())


@contextmanager
def refused_commits(engine: Engine) -> Iterator[None]:
    """Every statement is taken, and every COMMIT is refused: a full disk, or a constraint checked late."""
    if engine.dialect.name == "sqlite":
        with full_disk():
            yield
        return
    with engine.begin() as connection:
        connection.exec_driver_sql(
            "CREATE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS "
            "$$BEGIN RAISE 'no room' USING ERRCODE = 'disk_full'; END$$"
        )
        connection.exec_driver_sql(
            "CREATE CONSTRAINT TRIGGER refuse AFTER INSERT ON incidents DEFERRABLE INITIALLY DEFERRED "
            "FOR EACH ROW EXECUTE FUNCTION refuse()"
        )
    yield
    with engine.begin() as connection:
        connection.exec_driver_sql("DROP TRIGGER refuse ON incidents")


def test_a_refusal_that_nobody_waits_for_any_more_is_no_error(engine: Engine) -> None:
    async def scenario() -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = []
        asyncio.get_running_loop().set_exception_handler(lambda _, context: found.append(context))
        async with live(engine) as (transactions, _):
            asked = asyncio.create_task(transactions.run(refused))
            await asyncio.sleep(0)
            asked.cancel()
            await asyncio.gather(asked, return_exceptions=True)
        gc.collect()
        return found

    def refused(_: UnitOfWork) -> None:
        raise VehicleUnknown("no vehicle x is enrolled")

    assert asyncio.run(scenario()) == []


def test_when_the_commit_fails_nobody_is_told_that_it_was_done(engine: Engine) -> None:
    async def scenario() -> None:
        async with live(engine) as (transactions, heard):
            await transactions.run(opened("before"))
            await anext(heard)
            with refused_commits(engine):
                answers = await asyncio.gather(
                    *(transactions.run(opened(f"v{k}")) for k in range(5)), return_exceptions=True
                )
            assert all(isinstance(answer, StoreUnavailable) for answer in answers), answers
            assert await transactions.read(count_open) == 1
            stored = await transactions.run(opened("after"))
            _, payload = await asyncio.wait_for(anext(heard), 5.0)
            assert stored.encode() in payload, "what was not stored was told"

    asyncio.run(scenario())


def test_what_a_failed_commit_changed_is_unknown_to_the_next_use_case(engine: Engine) -> None:
    def save_plan(uow: UnitOfWork) -> None:
        uow.plans.save(Plan("snow-lion", "shuttle-1", 1, (), "rest-1"), 0)
        opened("lost")(uow)

    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            await transactions.run(opened("before"))
            with refused_commits(engine), pytest.raises(StoreUnavailable):
                await transactions.run(save_plan)
            assert await transactions.run(lambda uow: uow.plans.get("shuttle-1")) is None
            assert await transactions.run(count_open) == 1

    asyncio.run(scenario())


def test_reading_cannot_write(engine: Engine) -> None:
    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            with pytest.raises(AssertionError, match="only reads"):
                await transactions.read(opened("sly"))
            assert await transactions.read(count_open) == 0

    asyncio.run(scenario())


def test_the_database_refuses_what_a_reader_writes(engine: Engine) -> None:
    with engine.connect() as connection, pytest.raises(DBAPIError), read_only(connection):
        connection.execute(text("INSERT INTO counters VALUES ('snow-lion', 'sly', 1)"))
    with engine.connect() as connection:
        assert connection.execute(text("SELECT count(*) FROM counters")).scalar_one() == 0


def test_a_plan_is_saved_only_over_the_version_that_was_read(engine: Engine) -> None:
    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            first = Plan("snow-lion", "shuttle-1", 1, (), "rest-1")
            await transactions.run(lambda uow: uow.plans.save(first, 0))
            for stale in (0, 2):
                with pytest.raises(PlanChanged):
                    await transactions.run(
                        lambda uow, stale=stale: uow.plans.save(replace(first, version=9), stale)
                    )
            await transactions.run(lambda uow: uow.plans.save(replace(first, version=2), 1))
            assert (await transactions.read(lambda uow: uow.plans.get("shuttle-1"))).version == 2

    asyncio.run(scenario())


def test_no_two_vehicles_ever_have_one_resting_place(engine: Engine) -> None:
    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            await transactions.run(lambda uow: uow.plans.save(Plan("snow-lion", "a", 1, (), "rest-1"), 0))
            with pytest.raises(PlanChanged):
                await transactions.run(lambda uow: uow.plans.save(Plan("snow-lion", "b", 1, (), "rest-1"), 0))
            await transactions.run(lambda uow: uow.plans.save(Plan("snow-lion", "b", 1, (), ""), 0))
            await transactions.run(lambda uow: uow.plans.save(Plan("snow-lion", "c", 1, (), ""), 0))

    asyncio.run(scenario())


def test_a_conflict_is_decided_again_on_what_is_there_then(engine: Engine) -> None:
    """Two who raise the same counter by compare and set both get through."""

    def raise_version(uow: UnitOfWork) -> int:
        plan = uow.plans.get("shuttle-1") or Plan("snow-lion", "shuttle-1", 0)
        uow.plans.save(replace(plan, version=plan.version + 1), plan.version)
        return plan.version + 1

    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            await transactions.run(raise_version)
            versions = await asyncio.gather(*(transactions.run(raise_version) for _ in range(4)))
            assert sorted(versions) == [2, 3, 4, 5]

    asyncio.run(scenario())


@pytest.mark.parametrize(("conflicts", "stored"), [(ATTEMPTS - 1, True), (ATTEMPTS, False)])
def test_a_use_case_is_decided_again_a_bounded_number_of_times(
    engine: Engine, conflicts: int, stored: bool
) -> None:
    left = iter(range(conflicts))

    def contested(uow: UnitOfWork) -> str:
        made = opened("road")(uow)
        if next(left, None) is not None:
            raise PlanChanged("another one was faster")
        return made

    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            if stored:
                await transactions.run(contested)
            else:
                with pytest.raises(PlanChanged):
                    await transactions.run(contested)
            assert await transactions.read(count_open) == stored

    asyncio.run(scenario())


def test_bookings_at_the_same_moment_never_share_what_is_there_once(engine: Engine) -> None:
    """Three shuttles are on the road; six people book at once."""
    road_map = shipped_map("snow-lion")
    inline = CampusUnderTest(road_map, engine=engine)
    FakeFleet(inline, road_map, 3).start()
    inline.release()
    stops = [stop.stop_id for stop in road_map.stops]

    async def scenario() -> None:
        async with live(engine) as (transactions, _):
            made = await asyncio.gather(
                *(
                    transactions.run(
                        lambda uow, k=k: rides.book(uow, BookRide(stops[k], stops[k + 1], party=2))
                    )
                    for k in range(6)
                )
            )
            assert {ride.state for ride in made} <= {RideState.ASSIGNED, RideState.REFUSED}
            assert sum(ride.state is RideState.ASSIGNED for ride in made) >= 3
            plans = await transactions.read(lambda uow: uow.plans.all())
            for ride in made:
                if ride.state is RideState.ASSIGNED:
                    holders = [plan.vehicle_id for plan in plans if ride.ride_id in plan.ride_ids]
                    assert holders == [ride.vehicle_id]
            places = [plan.resting_place_id for plan in plans]
            assert len(set(places)) == len(places)

    asyncio.run(scenario())


def test_inline_transactions_roll_back_as_well() -> None:
    campus_ = CampusUnderTest(shipped_map("snow-lion"))
    with pytest.raises(VehicleUnknown):
        campus_.do(lambda uow: (opened("lost")(uow), commands.send_command(uow, "ghost", "hold", "x")))
    assert campus_.read(count_open) == 0
    assert isinstance(campus_.transactions, InlineTransactions)
    content = encode_map(shipped_map("snow-lion"))
    assert campus_.do(lambda uow: campus.load_map(uow, content, "test")).active
    campus_.close()


def test_a_preview_leaves_the_live_store_as_it_was_and_says_nothing(engine: Engine) -> None:
    """The writer keeps the fleet in memory: what a preview did there is taken back with its rows."""
    campus_ = CampusUnderTest(shipped_map("snow-lion"), engine=engine)
    fleet = FakeFleet(campus_, shipped_map("snow-lion"), 2).start()
    ride = fleet.book("NN20", "C6")
    vehicle_id = ride.vehicle_id or ""
    campus_.release()

    def preview(uow: UnitOfWork) -> Effects:
        return intervene(uow, vehicle_id, Intervention("recall"), "ann").effects

    def fleet_now(uow: UnitOfWork) -> object:
        known = uow.vehicles.all(), uow.plans.all(), uow.sections.all(), uow.incidents.all_open()
        return known, uow.rides.in_states(list(RideState)), uow.departures.unfinished()

    async def scenario() -> None:
        async with live(engine) as (transactions, heard):
            before = await transactions.run(fleet_now)
            said = await roll_back(transactions, preview)
            assert [effect.vehicle_before for effect in said.rides] == [vehicle_id]
            assert await transactions.run(fleet_now) == before
            assert await transactions.read(fleet_now) == before
            assert await transactions.run(preview) == said
            topic, _ = await anext(aiter(heard))
            assert topic.startswith("campus/snow-lion/")
            assert await transactions.run(fleet_now) != before

    asyncio.run(scenario())


@pytest.mark.parametrize("call", ["run", "read"])
def test_what_a_use_case_logs_in_another_thread_names_the_request(call: str, tmp_path: Path) -> None:
    write_fresh_database(tmp_path / "campusloop.db")

    async def scenario() -> object:
        async with live(open_engine(f"sqlite:///{tmp_path / 'campusloop.db'}")) as (transactions, _):
            with bound_contextvars(request_id="request-7"):
                return await getattr(transactions, call)(lambda _: get_contextvars())

    assert asyncio.run(scenario()) == {"request_id": "request-7"}
