"""The migrations make exactly the tables that the program uses."""

from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import Engine, create_engine, inspect, text

from server.store.engine import DatabaseUnsupported, open_engine
from server.store.schema import DatabaseTooNew, upgrade_to_head
from server.store.tables import metadata


def test_migrations_and_tables_agree(engine: Engine) -> None:
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, metadata) == []


def test_upgrading_again_changes_nothing(engine: Engine) -> None:
    before = sorted(inspect(engine).get_table_names())
    upgrade_to_head(engine)
    assert sorted(inspect(engine).get_table_names()) == before
    assert set(metadata.tables) <= set(before)


def test_every_table_belongs_to_a_campus() -> None:
    for table in metadata.tables.values():
        assert next(iter(table.primary_key.columns)).name == "campus_id"


def test_a_database_of_a_newer_program_is_left_alone(tmp_path: Path) -> None:
    engine = open_engine(f"sqlite:///{tmp_path}/new.db")
    upgrade_to_head(engine)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(DatabaseTooNew, match="update the program"):
        upgrade_to_head(engine)


def test_sqlite_files_are_in_write_ahead_mode(tmp_path: Path) -> None:
    engine = open_engine(f"sqlite:///{tmp_path}/wal.db")
    with engine.connect() as connection:
        assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
        assert connection.exec_driver_sql("PRAGMA synchronous").scalar() == 2


def test_a_database_we_do_not_speak_is_named() -> None:
    with pytest.raises(DatabaseUnsupported, match="mysql"):
        open_engine("mysql://localhost/campus")
    assert create_engine("sqlite://").dialect.name == "sqlite"
