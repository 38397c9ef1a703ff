"""The migrations make exactly the tables that the program uses."""

import json
from datetime import UTC, date, datetime
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from sqlalchemy import Connection, Engine, create_engine, inspect, text

from server.store.engine import DatabaseUnsupported, open_engine
from server.store.schema import MIGRATIONS, DatabaseTooNew, upgrade_to_head
from server.store.tables import metadata
from server.usecases.record.identity import sha256_of


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
        _insert_some_row(connection, "rides", {})
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


def test_links_of_before_there_were_ticket_keys_are_kept_as_hashes_and_codes_are_gone(engine: Engine) -> None:
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    order = {"visits": [{"board": [{"ride_id": "r", "party": 1, "code": "4821"}], "alight": []}]}
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0013")
        for table, changes in (
            (
                "rides",
                {"ride_id": "r", "token": "the-link", "boarding_code": "4821", "idempotency_key": "key"},
            ),
            ("rides", {"ride_id": "s", "token": "another-link", "idempotency_key": "series/s/2026-11-23"}),
            ("series", {"series_id": "s", "token": "a-series-link"}),
            ("orders", {"payload": json.dumps(order)}),
        ):
            _insert_some_row(connection, table, changes)
    upgrade_to_head(engine)
    with engine.connect() as connection:
        columns = "ride_id, old_token_sha256, ticket_key_id, idempotency_key"
        rides = connection.execute(text(f"SELECT {columns} FROM rides ORDER BY ride_id")).all()
        link = connection.execute(text("SELECT old_token_sha256 FROM series")).scalar_one()
        payload = connection.execute(text("SELECT payload FROM orders")).scalar_one()
        assert {"token", "boarding_code"}.isdisjoint(
            c["name"] for c in inspect(connection).get_columns("rides")
        )
    assert tuple(rides[0]) == ("r", sha256_of("the-link"), "", f"passenger:{sha256_of('key')}")
    assert tuple(rides[1]) == ("s", sha256_of("another-link"), "", "series/s/2026-11-23")
    assert link == sha256_of("a-series-link")
    assert json.loads(payload) == {"visits": [{"board": [{"ride_id": "r", "party": 1}], "alight": []}]}


def test_events_keep_their_order_and_their_counts_when_they_get_numbers(engine: Engine) -> None:
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    told = [("v", 0, 10), ("w", 0, 15), ("v", 1, 20)]
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0017")
        for vehicle_id, sequence, received_ns in reversed(told):
            row = {"campus_id": "c", "vehicle_id": vehicle_id, "boot_id": "b", "sequence": sequence}
            _insert_some_row(connection, "vehicle_events", row | {"received_ns": received_ns})
    upgrade_to_head(engine)
    numbered = "SELECT vehicle_id, sequence, received_ns FROM vehicle_events ORDER BY number"
    with engine.connect() as connection:
        assert [tuple(row) for row in connection.execute(text(numbered))] == told
        counts = connection.execute(text("SELECT vehicle_id, next_sequence FROM event_logs ORDER BY 1")).all()
        last = connection.execute(
            text("SELECT value FROM counters WHERE name = 'vehicle_event'")
        ).scalar_one()
    assert ([tuple(row) for row in counts], last) == ([("v", 2), ("w", 1)], 3)


def _insert_some_row(connection: Connection, table: str, values: dict[str, object]) -> None:
    required = {
        column["name"]: _some_value(str(column["type"]))
        for column in inspect(connection).get_columns(table)
        if not column["nullable"]
    } | values
    names, places = ", ".join(required), ", ".join(f":{name}" for name in required)
    connection.execute(text(f"INSERT INTO {table} ({names}) VALUES ({places})"), required)


def _some_value(kind: str) -> object:
    if kind in ("INTEGER", "BIGINT"):
        return 1
    if kind == "DATE":
        return date(2026, 11, 23)
    if kind == "BOOLEAN":
        return False
    return datetime(2026, 11, 23, tzinfo=UTC) if kind in ("DATETIME", "TIMESTAMP") else "x"
