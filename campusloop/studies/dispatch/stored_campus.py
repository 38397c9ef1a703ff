"""Reads a server's database without the server. It changes nothing, and the server may run meanwhile."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date, datetime, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

from sqlalchemy import Connection, Engine
from sqlalchemy.exc import SQLAlchemyError

from server.adapters import Argon2Hasher, RandomIds, SystemClock
from server.domain.errors import DomainError
from server.domain.rides.ticket_keys import TicketKeys
from server.domain.rules import FleetRules
from server.domain.service.timetable import local_moment
from server.settings import Settings, SettingsError, settings_from
from server.store.engine import DatabaseUnsupported, is_in_memory, open_engine, read_only
from server.store.roads.map_library import MapLibrary
from server.store.roads.maps import campuses
from server.store.schema import is_current
from server.store.unit_of_work import Context, SqlUnitOfWork
from server.usecases.ports.unit_of_work import UnitOfWork


class StoredCampusError(Exception):
    """The database cannot be read; the text says what to do."""


# Where `campusloop demo` keeps its campus, below the folder where the server would keep its own.
_DEMO = "demo"


def known_databases(database_url: str | None = None) -> tuple[str | None, ...]:
    """The databases to look in, as `database_url` of stored_campus.

    The given or the configured one alone; without either, that of a server here and that of the demo here.
    """
    try:
        settings = settings_from(os.environ, database_url=database_url)
    except SettingsError as error:
        raise StoredCampusError(str(error)) from error
    if settings.database_url:
        return (database_url,)
    places = [settings.var_dir / "campusloop.db", settings.var_dir / _DEMO / "campusloop.db"]
    return tuple(f"sqlite:///{path}" for path in places if path.is_file()) or (None,)


@contextmanager
def stored_campus(database_url: str | None = None) -> Iterator[UnitOfWork]:
    """A read-only transaction on the database that `campusloop serve` would use here.

    database_url  of another database, as in CAMPUSLOOP_DATABASE_URL

    Raises StoredCampusError.
    """
    try:
        settings = settings_from(os.environ, database_url=database_url)
        engine = _engine(settings)
    except (SettingsError, DatabaseUnsupported) as error:
        raise StoredCampusError(str(error)) from error
    shown = engine.url.render_as_string(hide_password=True)
    try:
        if not is_current(engine):
            raise StoredCampusError(
                f"{shown} is not of this version of the program; start the server on it once, then try again"
            )
        with engine.connect() as connection, read_only(connection):
            yield _unit_of_work(connection, _campus_id(connection, settings, shown))
    except SQLAlchemyError as error:
        raise StoredCampusError(f"{shown} cannot be read: {str(error).splitlines()[0]}") from error
    except DomainError as error:
        raise StoredCampusError(error.detail) from error
    finally:
        engine.dispose()


def local_day(uow: UnitOfWork, text: str) -> tuple[datetime, datetime]:
    """Begin and end of a day, YYYY-MM-DD, in the campus's time zone. Raises StoredCampusError."""
    zone = ZoneInfo(uow.network().road_map.timezone)
    try:
        day = date.fromisoformat(text)
        return local_moment(day, 0, zone), local_moment(day + timedelta(days=1), 0, zone)
    except (ValueError, OverflowError) as error:
        raise StoredCampusError(f"{text} is not a date; write it like 2026-01-08") from error


def _engine(settings: Settings) -> Engine:
    engine = open_engine(settings.database())
    if engine.dialect.name == "sqlite" and not is_in_memory(engine):
        path = Path(str(engine.url.database))
        if not path.is_file():
            raise StoredCampusError(
                f"there is no database {path}; run this where the server runs, or name its database with "
                "--database or CAMPUSLOOP_DATABASE_URL"
            )
    return engine


def _campus_id(connection: Connection, settings: Settings, shown: str) -> str:
    stored = campuses(connection)
    if not stored:
        raise StoredCampusError(f"{shown} holds no campus yet; start the server on it once")
    if settings.campus_id:
        if settings.campus_id not in stored:
            raise StoredCampusError(f"{shown} holds no campus {settings.campus_id}, but {', '.join(stored)}")
        return settings.campus_id
    if len(stored) > 1:
        raise StoredCampusError(f"{shown} holds {', '.join(stored)}; choose one with CAMPUSLOOP_CAMPUS_ID")
    return stored[0]


def _unit_of_work(connection: Connection, campus_id: str) -> UnitOfWork:
    # Hours and sessions differ between installations; the data read here depend on neither.
    rules = FleetRules()
    context = Context(
        campus_id, SystemClock(), RandomIds(), rules, Argon2Hasher(), MapLibrary(rules), TicketKeys(())
    )
    return SqlUnitOfWork(connection, context)
