"""Databases that are full, locked, cut off or read by others."""

import asyncio
import resource
import sqlite3
import subprocess
import time

import psycopg
from sqlalchemy import select

from benchmarks.faults.installation import Installation, free_port
from benchmarks.faults.stage import Stage, require
from server.store import tables
from server.store.engine import open_engine

FULL_S = 15.0
LOCKED_S = 13.0
READS_S = 10.0
AWAY_S = 12.0
READ_ONLY_S = 8.0
_END_OTHERS = (
    "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = current_database() "
    "AND pid <> pg_backend_pid() AND NOT pid = ANY(%s)"
)


async def disk_full(stage: Stage) -> None:
    """For 15 s the operating system refuses every byte that the server writes."""
    pid = stage.installation.process.pid
    _, hard = resource.prlimit(pid, resource.RLIMIT_FSIZE)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (0, hard))
    await asyncio.sleep(FULL_S)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (hard, hard))
    await stage.installation.until_ready()


async def database_locked(stage: Stage) -> None:
    """A backup tool holds the database's lock for 13 s."""
    await asyncio.to_thread(_hold_lock, stage.installation)
    await stage.installation.until_ready()


async def database_backed_up(stage: Stage) -> None:
    """The database is copied while the server writes to it."""

    def copy() -> None:
        source = sqlite3.connect(stage.installation.sqlite_file)
        target = sqlite3.connect(":memory:")
        source.backup(target, pages=5, sleep=0.01)
        rides = target.execute("SELECT count(*) FROM rides").fetchone()[0]
        source.close()
        require(rides > 0, "the copy has no rides")

    await asyncio.sleep(2.0)
    await asyncio.to_thread(copy)


async def connections_killed(stage: Stage) -> None:
    """The database ends every connection, five times."""
    for _ in range(5):
        await asyncio.to_thread(_end_connections, stage.installation.database_url)
        await asyncio.sleep(1.0)
    await stage.installation.until_ready()


async def long_reader(stage: Stage) -> None:
    """A report reads the rides in one transaction of 10 s."""

    def read() -> None:
        engine = open_engine(stage.installation.url)
        with engine.connect() as connection:
            rides = connection.execute(select(tables.rides)).all()
            time.sleep(READS_S)
            again = connection.execute(select(tables.rides)).all()
            require(len(again) >= len(rides), "rides are gone")
        engine.dispose()

    await asyncio.to_thread(read)


async def database_killed(stage: Stage) -> None:
    """SIGKILL of the database server, twice; it is started again at once and recovers by its log."""
    for _ in range(2):
        await asyncio.sleep(stage.rng.uniform(0.5, 2.0))
        await asyncio.to_thread(stage.postgresql.kill)
        await asyncio.to_thread(stage.postgresql.start)
        await stage.installation.until_ready()


async def database_away(stage: Stage) -> None:
    """The database server is gone for 12 s: longer than a request waits for it."""
    await asyncio.to_thread(stage.postgresql.kill)
    await asyncio.sleep(AWAY_S)
    await asyncio.to_thread(stage.postgresql.start)


async def database_read_only(stage: Stage) -> None:
    """For 8 s the address leads to a database that takes no writes, as after a failover to a standby."""
    await asyncio.to_thread(_set_read_only, stage.installation.database_url, "on")
    await asyncio.sleep(READ_ONLY_S)
    await asyncio.to_thread(_set_read_only, stage.installation.database_url, "off")


async def connections_used_up(stage: Stage) -> None:
    """Others have all connections of the database for 8 s, and the server's own are ended."""

    def use_up() -> None:
        url = stage.installation.database_url
        held: list[psycopg.Connection] = []
        try:
            with psycopg.connect(url, autocommit=True) as control:
                while len(held) < 200:
                    try:
                        held.append(psycopg.connect(url))
                    except psycopg.OperationalError:
                        control.execute(_END_OTHERS, ([one.info.backend_pid for one in held],))
                        if len(held) > 90:
                            break
                time.sleep(READ_ONLY_S)
        finally:
            for one in held:
                one.close()

    await asyncio.to_thread(use_up)


async def second_server_on_one_file(stage: Stage) -> None:
    """Another server is started on the same SQLite file: it must refuse and say what to do."""
    installation = stage.installation
    second = await asyncio.to_thread(
        subprocess.run,
        installation.command(free_port()),
        env=installation.environment(),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    require(second.returncode != 0, "the second server started")
    require("Traceback" not in second.stderr, second.stderr[-300:])


def _set_read_only(url: str, value: str) -> None:
    with psycopg.connect(url, autocommit=True) as connection:
        connection.execute("SET default_transaction_read_only = off")
        connection.execute(f"ALTER SYSTEM SET default_transaction_read_only = {value}")
        connection.execute("SELECT pg_reload_conf()")


def _hold_lock(installation: Installation) -> None:
    if installation.is_sqlite:
        held = sqlite3.connect(installation.sqlite_file, isolation_level=None)
        held.execute("BEGIN IMMEDIATE")
        time.sleep(LOCKED_S)
        held.execute("ROLLBACK")
        held.close()
        return
    with psycopg.connect(installation.database_url) as connection:
        connection.execute("LOCK TABLE vehicles, rides, plans IN ACCESS EXCLUSIVE MODE")
        time.sleep(LOCKED_S)


def _end_connections(url: str) -> None:
    with psycopg.connect(url, autocommit=True) as connection:
        connection.execute(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
            "WHERE datname = current_database() AND pid <> pg_backend_pid()"
        )
