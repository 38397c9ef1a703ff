"""A backup of a PostgreSQL database by PostgreSQL's own programs, which know its format."""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from psycopg.conninfo import make_conninfo
from sqlalchemy import URL

from server.store.backups.backup import BackupRefused, draft_beside, publish_new
from server.store.schema import known_revisions

_DUMP, _RESTORE = "pg_dump", "pg_restore"


@dataclass(frozen=True, slots=True)
class DumpContents:
    """revision: of the schema, as Alembic stores it"""

    revision: str
    size_bytes: int


def dump(url: URL, target: Path, search_path: str | None = None) -> DumpContents:
    """Write an archive of pg_dump to `target`, which appears only when it is complete and has been read back.

    search_path: folders of the programs; None for those of the environment

    Raises BackupRefused.
    """
    found = {name: shutil.which(name, path=search_path) for name in (_DUMP, _RESTORE)}
    if missing := [name for name, program in found.items() if program is None]:
        raise BackupRefused(
            f"the programs {' and '.join(missing)} are missing: install PostgreSQL's client programs in the "
            "version of the server or a newer one (Debian: postgresql-client)"
        )
    try:
        with draft_beside(target) as draft:
            options = ("--format=custom", "--no-owner", "--no-privileges", f"--file={draft}")
            _run(str(found[_DUMP]), *options, f"--dbname={_address(url)}", password=url.password)
            revision = _verified_revision(str(found[_RESTORE]), draft)
            publish_new(draft, target)
    except FileExistsError as error:
        raise BackupRefused(f"{target} exists; give another name") from error
    except OSError as error:
        raise BackupRefused(str(error)) from error
    return DumpContents(revision, target.stat().st_size)


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
