"""The database file that a command means: of an option, or of the settings as `serve` reads them."""

from collections.abc import Mapping
from pathlib import Path

from sqlalchemy.exc import ArgumentError

from server.settings import settings_from
from server.store.database_file import database_path
from server.store.engine import DatabaseUnsupported, open_engine


class NoDatabaseFile(Exception):
    """The database is not a file of SQLite; the text says what to use instead."""


def chosen_database(environment: Mapping[str, str], url: str | None, instead: str) -> Path:
    """The SQLite file named by the option or by the settings.

    instead: what does the same on PostgreSQL

    Raises NoDatabaseFile and SettingsError.
    """
    settings = settings_from(environment, database_url=url)
    try:
        engine = open_engine(settings.database())
    except (DatabaseUnsupported, ArgumentError) as error:
        raise NoDatabaseFile(str(error)) from error
    if engine.dialect.name == "postgresql":
        shown = engine.url.render_as_string(hide_password=True)
        raise NoDatabaseFile(f"{shown} is a PostgreSQL database, which has tools of its own: {instead}")
    path = database_path(engine)
    if path is None:
        raise NoDatabaseFile("a database in memory has no backup; use sqlite:///FILE")
    return path
