"""Databases that are full, locked, cut off or read by others."""

import asyncio
import resource
import sqlite3
import subprocess
import time

import psycopg

from benchmarks.faults.installation import Installation, free_port
from benchmarks.faults.stage import Stage, require

FULL_S = 15.0
LOCKED_S = 13.0


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
