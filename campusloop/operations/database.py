"""Checks of the database: reachable, of this version, sound. They write nothing."""

import os
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy import Engine, select
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from campusloop.operations.finding import Finding, bad, good, warning
from server.settings import Settings
from server.store.backups.contents import BadDatabaseFile, database_contents, opened, reading
from server.store.database_file import database_path
from server.store.engine import DatabaseUnsupported, open_engine
from server.store.schema import head_revision, known_revisions, present_revision
from server.store.tables import server_events
from server.store.writing.failures import cause_of

_MIGRATES = "nothing: the server migrates it when it starts (make a backup before)"


def check_database(settings: Settings) -> tuple[Finding, datetime | None]:
    """(the finding, when the newest event in the database happened)"""
    try:
        engine = open_engine(settings.database())
    except (DatabaseUnsupported, ArgumentError) as error:
        return bad("database", str(error), "set CAMPUSLOOP_DATABASE_URL"), None
    path = database_path(engine)
    if path is not None:
        return _file(path)
    if engine.dialect.name == "sqlite":
        remedy = "set CAMPUSLOOP_DATABASE_URL to sqlite:///FILE"
        return warning("database", "it is in memory and ends with the server", remedy), None
    return _postgresql(engine)


def _file(path: Path) -> tuple[Finding, datetime | None]:
    try:
        if not path.exists():
            return good("database", f"{path} is made at the first start"), None
        if not os.access(path, os.R_OK | os.W_OK):
            remedy = "run this as the server's user, or give it the file (chown)"
            return bad("database", f"{path} cannot be written by this user", remedy), None
        contents = database_contents(path)
        newest = _newest_event(path)
    except (BadDatabaseFile, OSError) as error:
        remedy = "stop the server and restore a backup: campusloop restore --from FILE --replace"
        return bad("database", str(error), remedy), None
    if not contents.is_current:
        text = f"{path} is sound, of an earlier version ({contents.revision})"
        return warning("database", text, _MIGRATES), newest
    return good("database", f"{path} is sound, revision {contents.revision}"), newest


def _newest_event(path: Path) -> datetime | None:
    with opened(path, reading(path)) as connection:
        row = connection.execute("SELECT max(happened_at) FROM server_events").fetchone()
    return None if row[0] is None else datetime.fromisoformat(row[0]).replace(tzinfo=UTC)


def _postgresql(engine: Engine) -> tuple[Finding, datetime | None]:
    shown = engine.url.render_as_string(hide_password=True)
    try:
        present = present_revision(engine)
        newest = None
        if present == head_revision():
            with engine.connect() as connection:
                newest = connection.execute(
                    select(server_events.c.happened_at).order_by(server_events.c.happened_at.desc()).limit(1)
                ).scalar()
    except SQLAlchemyError as error:
        remedy = "start it, or set CAMPUSLOOP_DATABASE_URL"
        return bad("database", f"{shown} cannot be used ({cause_of(error)})", remedy), None
    finally:
        engine.dispose()
    if present is None:
        return good("database", f"{shown} answers; its tables are made at the first start"), None
    if present not in known_revisions():
        text = f"{shown} is at revision {present}, which this version does not know"
        return bad("database", text, "update the program"), None
    if present != head_revision():
        return warning("database", f"{shown} is of an earlier version ({present})", _MIGRATES), newest
    return good("database", f"{shown} answers, revision {present}"), newest
