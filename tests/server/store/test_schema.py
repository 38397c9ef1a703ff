"""The migrations make exactly the tables that the program uses."""

from datetime import UTC, datetime
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from sqlalchemy import Engine, create_engine, inspect, text

from server.store.engine import DatabaseUnsupported, open_engine
from server.store.schema import MIGRATIONS, DatabaseTooNew, upgrade_to_head
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


def test_rides_of_the_first_tables_are_kept_by_the_later_ones(engine: Engine) -> None:
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0001")
        columns = {column["name"] for column in inspect(connection).get_columns("rides")}
        assert "let_out" not in columns
        required = {
            column["name"]: _some_value(str(column["type"]))
            for column in inspect(connection).get_columns("rides")
            if not column["nullable"]
        }
        names = ", ".join(required)
        values = ", ".join(f":{name}" for name in required)
        connection.execute(text(f"INSERT INTO rides ({names}) VALUES ({values})"), required)
    upgrade_to_head(engine)
    with engine.connect() as connection:
        row = connection.execute(text("SELECT let_out, arrive_before, series_id FROM rides")).one()
    assert (bool(row.let_out), row.arrive_before, row.series_id) == (False, None, None)


def test_travel_time_factors_are_kept_under_their_new_name_and_back(engine: Engine) -> None:
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0009")
        row = {"campus_id": "c", "factors": "[1.5]", "legs": "[3]", "at": datetime(2026, 11, 23, tzinfo=UTC)}
        connection.execute(
            text("INSERT INTO paces VALUES (:campus_id, :factors, :legs, :at)"),
            row,
        )
    upgrade_to_head(engine)
    with engine.connect() as connection:
        kept = connection.execute(text("SELECT factors, legs FROM travel_time_factors")).one()
        assert "paces" not in inspect(connection).get_table_names()
    assert tuple(kept) == ("[1.5]", "[3]")


def _some_value(kind: str) -> object:
    if kind == "INTEGER":
        return 1
    if kind == "BOOLEAN":
        return False
    return datetime(2026, 11, 23, tzinfo=UTC) if kind in ("DATETIME", "TIMESTAMP") else "x"
