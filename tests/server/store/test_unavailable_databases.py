"""A database that is locked, full, cut off or replaced: callers learn the truth, and the writer goes on."""

import asyncio
import os
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event, text

from server.adapters import RandomIds
from server.bus.in_process import InProcessBus, LocalSubscription
from server.domain.errors import OutcomeUnknown, StoreUnavailable
from server.domain.record.incidents import IncidentKind
from server.domain.rules import FleetRules
from server.store.engine import open_engine
from server.store.roads.map_library import MapLibrary
from server.store.transactions import GroupCommit
from server.store.unit_of_work import Context
from server.store.writing.retries import NO_RETRIES, Retries
from server.store.writing.writer import Job, Writer
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import incidents
from tests.full_disk import full_disk
from tests.server.conftest import CLOSE_OTHERS
from tests.server.store.database_faults import CuttingProxy, locked_by_another_process
from tests.server.usecases.campus_under_test import TICKET_KEYS, HandClock, PlainHasher
from tests.server.usecases.fresh_database import write_fresh_database

KILL = """SELECT pg_terminate_backend(pid) FROM pg_stat_activity
WHERE datname = current_database() AND pid <> pg_backend_pid() AND query LIKE :query"""
# Many pages: the transaction does not fit into SQLite's cache and is written before its end.
LARGE = "x" * 4_000_000


def context() -> Context:
    rules = FleetRules()
    return Context(
        "snow-lion", HandClock(), RandomIds(), rules, PlainHasher(), MapLibrary(rules), TICKET_KEYS
    )


@asynccontextmanager
async def live(url: str, retries: Retries) -> AsyncIterator[tuple[GroupCommit, LocalSubscription]]:
    """The live transactions of this database, and all that they publish."""
    bus = InProcessBus()
    heard = await bus.subscribe("campus/>")
    transactions = GroupCommit(open_engine(url), context(), bus, retries)
    yield transactions, heard
    await transactions.close()


def opened(subject: str, cause: str = "test") -> Callable[[UnitOfWork], str]:
    def work(uow: UnitOfWork) -> str:
        return incidents.open_incident(uow, IncidentKind.TAKEOVER, subject, cause).incident_id

    return work


def subjects(uow: UnitOfWork) -> list[str]:
    return sorted(incident.subject for incident in uow.incidents.all_open())


def until(pauses: int, end: Callable[[], object]) -> Retries:
    """Retries without a real wait; what is wrong ends at this pause."""
    left = iter(range(pauses))

    def pause(_: float) -> bool:
        if next(left, None) == pauses - 1:
            end()
        return True

    return Retries(pause=pause)


def run(scenario: Coroutine[None, None, None]) -> None:
    asyncio.run(asyncio.wait_for(scenario, 60.0))


@pytest.fixture
def sqlite_file(tmp_path: Path) -> Path:
    write_fresh_database(tmp_path / "campusloop.db")
    return tmp_path / "campusloop.db"


@pytest.fixture
def proxy(new_postgresql: Callable[[], str]) -> Iterator[CuttingProxy]:
    made = CuttingProxy(new_postgresql())
    yield made
    made.close()


def test_a_use_case_waits_until_another_process_releases_sqlite(sqlite_file: Path) -> None:
    async def scenario() -> None:
        with locked_by_another_process(sqlite_file) as release:
            async with live(f"sqlite:///{sqlite_file}", until(2, release)) as (transactions, _):
                await transactions.run(opened("one"))
                assert await transactions.read(subjects) == ["one"]

    run(scenario())


def test_when_sqlite_stays_locked_all_that_wait_are_refused_and_the_next_is_stored(sqlite_file: Path) -> None:
    async def scenario() -> None:
        async with live(f"sqlite:///{sqlite_file}", NO_RETRIES) as (transactions, _):
            with locked_by_another_process(sqlite_file):
                answers = await asyncio.gather(
                    *(transactions.run(opened(f"v{k}")) for k in range(5)), return_exceptions=True
                )
            assert {type(answer) for answer in answers} == {StoreUnavailable}
            assert "locked" in str(answers[0])
            await transactions.run(opened("after"))
            assert await transactions.read(subjects) == ["after"]
            assert await transactions.run(subjects) == ["after"]

    run(scenario())


@contextmanager
def disk_filled() -> Iterator[Callable[[], None]]:
    """A full disk, and what makes room on it."""
    filled = full_disk()
    filled.__enter__()
    room = iter([lambda: filled.__exit__(None, None, None)])

    def free() -> None:
        make_room = next(room, None)
        if make_room is not None:
            make_room()

    try:
        yield free
    finally:
        free()


@pytest.mark.parametrize("cause", ["small", LARGE], ids=["at-the-commit", "within-a-use-case"])
def test_a_group_that_finds_the_disk_full_is_stored_whole_when_there_is_room(
    sqlite_file: Path, cause: str
) -> None:
    async def scenario() -> None:
        with disk_filled() as free:
            async with live(f"sqlite:///{sqlite_file}", until(3, free)) as (transactions, _):
                await asyncio.gather(*(transactions.run(opened(f"v{k}", cause)) for k in range(3)))
                assert await transactions.read(subjects) == ["v0", "v1", "v2"]

    run(scenario())


@pytest.mark.parametrize("cause", ["small", LARGE], ids=["at-the-commit", "within-a-use-case"])
def test_while_the_disk_is_full_nothing_is_acknowledged_and_nothing_is_half_stored(
    sqlite_file: Path, cause: str
) -> None:
    async def scenario() -> None:
        async with live(f"sqlite:///{sqlite_file}", NO_RETRIES) as (transactions, heard):
            await transactions.run(opened("before"))
            await anext(heard)
            with full_disk():
                answers = await asyncio.gather(
                    *(transactions.run(opened(f"v{k}", cause)) for k in range(3)), return_exceptions=True
                )
            assert {type(answer) for answer in answers} == {StoreUnavailable}
            assert await transactions.read(subjects) == ["before"]
            after = await transactions.run(opened("after"))
            assert after.encode() in (await anext(heard))[1], "what was not stored was told"
            assert await transactions.read(subjects) == ["after", "before"]
            assert await transactions.run(subjects) == ["after", "before"]

    run(scenario())


def test_what_sqlite_has_no_room_for_is_not_remembered_either(sqlite_file: Path) -> None:
    """By SQLite's own limit of pages: its connection is used on, and so is what is kept in memory of it."""
    connections: list[Any] = []
    engine = open_engine(f"sqlite:///{sqlite_file}")
    event.listen(engine, "connect", lambda raw, _: connections.append(raw))
    writer = Writer(engine, context(), NO_RETRIES)

    def write(*works: Callable[[UnitOfWork], Any]) -> list[Any]:
        jobs = [Job(work) for work in works]
        writer.write(jobs)
        return [job.result()[0] for job in jobs]

    write(opened("before"))
    assert write(subjects) == [["before"]]
    connections[0].execute("PRAGMA max_page_count=1").close()
    with pytest.raises(StoreUnavailable, match="full"):
        write(opened("lost with it"), opened("lost", LARGE))
    assert write(subjects) == [["before"]]
    connections[0].execute("PRAGMA max_page_count=4294967294").close()
    write(opened("after", LARGE))
    assert write(subjects) == [["after", "before"]]
    assert len(connections) == 1
    writer.close()
    engine.dispose()


def test_a_database_file_that_was_replaced_takes_nothing_until_the_server_is_restarted(
    sqlite_file: Path,
) -> None:
    async def scenario() -> None:
        async with live(f"sqlite:///{sqlite_file}", NO_RETRIES) as (transactions, _):
            await transactions.run(opened("before"))
            os.replace(sqlite_file, sqlite_file.with_name("moved.db"))
            with pytest.raises(StoreUnavailable, match="stop the server"):
                await transactions.run(opened("into a file without a name"))
            write_fresh_database(sqlite_file)
            with pytest.raises(StoreUnavailable, match="stop the server"):
                await transactions.run(opened("into the copy"))

    run(scenario())


def test_connections_killed_by_the_database_are_replaced_and_the_work_is_repeated(
    new_postgresql: Callable[[], str],
) -> None:
    url = new_postgresql()
    other = open_engine(url)

    runs: list[str] = []

    def work(uow: UnitOfWork) -> str:
        runs.append("run")
        made = opened("killed")(uow)
        if len(runs) == 1:
            with other.begin() as connection:
                connection.execute(text(CLOSE_OTHERS))
        return made

    async def scenario() -> None:
        async with live(url, until(1, lambda: None)) as (transactions, _):
            await transactions.run(opened("before"))
            with other.begin() as connection:
                connection.execute(text(CLOSE_OTHERS))
            await transactions.run(opened("between"))
            await transactions.run(work)
            assert runs == ["run", "run"]
            assert await transactions.read(subjects) == ["before", "between", "killed"]

    run(scenario())
    other.dispose()


def test_a_commit_whose_answer_is_lost_is_neither_repeated_nor_refused(proxy: CuttingProxy) -> None:
    runs: list[str] = []

    def work(uow: UnitOfWork) -> str:
        runs.append("run")
        return opened("once")(uow)

    async def scenario() -> None:
        async with live(proxy.url, until(1, lambda: None)) as (transactions, heard):
            await transactions.run(opened("before"))
            await anext(heard)
            proxy.cut_at_commit = True
            made = await transactions.run(work)
            assert made.encode() in (await anext(heard))[1]
            assert runs == ["run"]
            assert await transactions.run(subjects) == await transactions.read(subjects) == ["before", "once"]

    run(scenario())


def test_a_commit_that_the_database_gave_up_is_repeated(new_postgresql: Callable[[], str]) -> None:
    """The connection is killed while a constraint is checked within COMMIT."""
    url = new_postgresql()
    other = open_engine(url)
    with other.begin() as connection:
        for statement in (
            "CREATE FUNCTION slow() RETURNS trigger LANGUAGE plpgsql AS "
            "$$BEGIN IF NEW.subject = 'slow' THEN PERFORM pg_sleep(30); END IF; RETURN NEW; END$$",
            "CREATE CONSTRAINT TRIGGER slow AFTER INSERT ON incidents DEFERRABLE INITIALLY DEFERRED "
            "FOR EACH ROW EXECUTE FUNCTION slow()",
        ):
            connection.exec_driver_sql(statement)

    async def scenario() -> None:
        async with live(url, until(1, lambda: None)) as (transactions, _):
            await transactions.run(opened("before"))
            making = asyncio.create_task(transactions.run(opened("slow")))
            for _ in range(600):
                with other.begin() as connection:
                    killed = connection.execute(text(KILL), {"query": "COMMIT%"}).all()
                    if killed:
                        connection.exec_driver_sql("ALTER TABLE incidents DISABLE TRIGGER slow")
                        break
                await asyncio.sleep(0.05)
            await making
            assert await transactions.read(subjects) == ["before", "slow"]

    run(scenario())
    other.dispose()


def test_a_commit_of_which_the_database_cannot_be_asked_is_told_as_unknown(proxy: CuttingProxy) -> None:
    async def scenario() -> None:
        async with live(proxy.url, Retries(patience_s=0.3)) as (transactions, heard):
            await transactions.run(opened("before"))
            await anext(heard)
            proxy.cut_at_commit = proxy.refuse_after_cut = True
            with pytest.raises(OutcomeUnknown, match="Idempotency-Key"):
                await transactions.run(opened("perhaps"))
            with pytest.raises(StoreUnavailable):
                await transactions.run(opened("refused"))
            with pytest.raises(StoreUnavailable):
                await transactions.read(subjects)
            proxy.refusing = False
            after = await transactions.run(opened("after"))
            assert after.encode() in (await anext(heard))[1]
            assert await transactions.run(subjects) == ["after", "before", "perhaps"]

    run(scenario())


def test_a_commit_that_another_server_has_covered_is_told_as_unknown(proxy: CuttingProxy) -> None:
    """Its mark is gone, so this server cannot say whether its own transaction was the one before."""

    async def scenario() -> None:
        async with live(proxy.direct_url, NO_RETRIES) as (second, _):

            def covered(_: float) -> bool:
                asyncio.run_coroutine_threadsafe(second.run(opened("later")), loop).result(30.0)
                return True

            loop = asyncio.get_running_loop()
            async with live(proxy.url, Retries(pause=covered)) as (first, _):
                await first.run(opened("before"))
                proxy.cut_at_commit = True
                with pytest.raises(OutcomeUnknown):
                    await first.run(opened("perhaps"))
                assert await first.run(subjects) == ["before", "later", "perhaps"]

    run(scenario())
