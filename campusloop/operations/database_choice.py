"""The database that a command means: of an option, or of the settings as `serve` reads them."""

from collections.abc import Mapping
from pathlib import Path

from sqlalchemy import URL
from sqlalchemy.exc import ArgumentError

from server.settings import settings_from
from server.store.database_file import database_path
from server.store.engine import DatabaseUnsupported, open_engine


class NoSuchDatabase(Exception):
    """The database cannot be copied or restored; the text says which can."""


def chosen_database(environment: Mapping[str, str], url: str | None) -> Path | URL:
    """The file of an SQLite database, or the address of a PostgreSQL database.

    Raises NoSuchDatabase and SettingsError.
    """
    settings = settings_from(environment, database_url=url)
    try:
        engine = open_engine(settings.database())
    except (DatabaseUnsupported, ArgumentError) as error:
        raise NoSuchDatabase(str(error)) from error
    if engine.dialect.name == "postgresql":
        return engine.url
    path = database_path(engine)
    if path is None:
        raise NoSuchDatabase("a database in memory has no backup; use sqlite:///FILE")
    return path
