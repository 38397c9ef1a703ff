"""Backup and restore of a PostgreSQL database by PostgreSQL's own programs, which know its format."""

import os
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from psycopg.conninfo import make_conninfo
from sqlalchemy import URL, Connection, create_engine, text
from sqlalchemy.exc import SQLAlchemyError

from server.store.backups.backup import BackupRefused, draft_beside, publish_new
from server.store.backups.restore import RestoreRefused
from server.store.schema import head_revision, known_revisions

_DUMP, _RESTORE, _SHELL = "pg_dump", "pg_restore", "psql"
_LOOKS_MAX, _LOOK_EVERY_S = 20, 0.1
_OTHERS = """SELECT count(*) FROM pg_stat_activity
WHERE datname = current_database() AND pid <> pg_backend_pid() AND backend_type = 'client backend'"""
_TABLES = "SELECT count(*) FROM pg_tables WHERE schemaname = 'public'"
# What a newer version has added is not in the archive, and goes too.
_EMPTY = "DROP SCHEMA public CASCADE; CREATE SCHEMA public;"


@dataclass(frozen=True, slots=True)
class DumpContents:
    """revision: of the schema, as Alembic stores it"""

    revision: str
    size_bytes: int

    @property
    def is_current(self) -> bool:
        return self.revision == head_revision()


def dump(url: URL, target: Path, search_path: str | None = None) -> DumpContents:
    """Write an archive of pg_dump to `target`, which appears only when it is complete and has been read back.

    search_path: folders of the programs; None for those of the environment

    Raises BackupRefused.
    """
    programs = _programs(search_path, _DUMP, _RESTORE)
    try:
        with draft_beside(target) as draft:
            options = ("--format=custom", "--no-owner", "--no-privileges", f"--file={draft}")
            _run(programs[_DUMP], *options, f"--dbname={_address(url)}", password=url.password)
            revision = _verified_revision(programs[_RESTORE], draft)
            publish_new(draft, target)
    except FileExistsError as error:
        raise BackupRefused(f"{target} exists; give another name") from error
    except OSError as error:
        raise BackupRefused(str(error)) from error
    return DumpContents(revision, target.stat().st_size)


@dataclass(frozen=True, slots=True)
class RestoredDump:
    """kept: the archive of what was in the database before; None if it was empty."""

    contents: DumpContents
    kept: Path | None


def restore_dump(
    backup: Path, url: URL, kept: Path, *, replace: bool, search_path: str | None = None
) -> RestoredDump:
    """Put an archive of `dump` in the place of the database, in one transaction.

    kept     where the present content goes first
    replace  the database may have content

    Raises RestoreRefused: the database is as it was.
    """
    try:
        programs = _programs(search_path, _DUMP, _RESTORE, _SHELL)
        revision = _verified_revision(programs[_RESTORE], backup)
        had_tables = _has_tables(url)
        if had_tables and not replace:
            raise RestoreRefused(f"the database has tables; with --replace they go to {kept} first")
        if had_tables:
            dump(url, kept, search_path)
        with draft_beside(kept.with_suffix(".sql")) as script:
            _run(programs[_RESTORE], "--no-owner", "--no-privileges", f"--file={script}", str(backup))
            options = ("--no-psqlrc", "--quiet", "--single-transaction", "--set=ON_ERROR_STOP=1")
            steps = (f"--command={_EMPTY}", f"--file={script}", f"--dbname={_address(url)}")
            _run(programs[_SHELL], *options, *steps, password=url.password)
    except (BackupRefused, OSError) as error:
        raise RestoreRefused(str(error)) from error
    contents = DumpContents(revision, backup.stat().st_size)
    return RestoredDump(contents, kept if had_tables else None)


def _has_tables(url: URL) -> bool:
    """Raises RestoreRefused for a database that is used or out of reach."""
    engine = create_engine(url)
    try:
        with engine.connect() as connection:
            others = _other_connections(connection)
            tables = connection.execute(text(_TABLES)).scalar_one()
    except SQLAlchemyError as error:
        raise RestoreRefused(str(error.__cause__ or error)) from error
    finally:
        engine.dispose()
    if others:
        raise RestoreRefused(f"{others} connections use the database; stop the servers, and restore again")
    return bool(tables)


def _other_connections(connection: Connection) -> int:
    # A connection that was closed just now is still listed for a moment.
    for _ in range(_LOOKS_MAX):
        others = int(connection.execute(text(_OTHERS)).scalar_one())
        if not others:
            return 0
        # The transaction shows one state of the statistics.
        connection.rollback()
        time.sleep(_LOOK_EVERY_S)
    return others


def _programs(search_path: str | None, *names: str) -> dict[str, str]:
    """Their paths. Raises BackupRefused."""
    found = {name: shutil.which(name, path=search_path) for name in names}
    if missing := [name for name, program in found.items() if program is None]:
        raise BackupRefused(
            f"the programs {' and '.join(missing)} are missing: install PostgreSQL's client programs in the "
            "version of the server or a newer one (Debian: postgresql-client)"
        )
    return {name: str(program) for name, program in found.items()}


def _address(url: URL) -> str:
    """Without the password: every user of the machine sees the arguments of a program."""
    parts: dict[str, str | int | None] = {
        "host": url.host, "port": url.port, "user": url.username, "dbname": url.database,
    }  # fmt: skip
    # A socket's folder or several hosts are given behind the question mark.
    parts |= {name: value if isinstance(value, str) else ",".join(value) for name, value in url.query.items()}
    return make_conninfo("", **parts)


def _verified_revision(program: str, draft: Path) -> str:
    """Read the whole archive back. Returns the revision in it."""
    _run(program, f"--file={os.devnull}", str(draft))
    lines = _run(program, "--data-only", "--table=alembic_version", "--file=-", str(draft)).splitlines()
    heads = [k for k, line in enumerate(lines) if line.startswith("COPY ")]
    revision = lines[heads[0] + 1] if heads else ""
    if revision not in known_revisions():
        raise BackupRefused(
            f"the database is at revision {revision or 'none'}, which this version does not know; "
            "is it a Campusloop database, and is the program up to date?"
        )
    return revision


def _run(program: str, *arguments: str, password: str | None = None) -> str:
    environment = os.environ | ({} if password is None else {"PGPASSWORD": password})
    done = subprocess.run((program, *arguments), env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise BackupRefused(done.stderr.strip() or f"{program} ended with {done.returncode}")
    return done.stdout
