"""One statement for many rows stores what a statement for each row stores."""

from datetime import UTC, datetime, timedelta

import pytest
from sqlalchemy import Column, Integer, MetaData, String, Table, create_engine, insert, select

from server.store.columns import Utc
from server.store.writing.many_rows import insert_rows

NOON = datetime(2026, 1, 2, 12, 0, 0, 345, tzinfo=UTC)
_TABLE = Table(
    "rows",
    MetaData(),
    Column("campus_id", String(64), primary_key=True),
    Column("name", String(64), primary_key=True),
    Column("value", Integer, nullable=True),
    Column("at", Utc(), nullable=False),
)


def _rows(count: int, value: int | None = 1) -> list[dict[str, object]]:
    return [
        {"campus_id": "c", "name": f"n{k:04}", "value": value, "at": NOON + timedelta(seconds=k)}
        for k in range(count)
    ]


def _stored(count: int, *, by_one_statement: bool) -> list[tuple[object, ...]]:
    with create_engine("sqlite://").begin() as connection:
        _TABLE.create(connection)
        if by_one_statement:
            insert_rows(connection, _TABLE, _rows(count))
        else:
            connection.execute(insert(_TABLE), _rows(count))
        return [tuple(row) for row in connection.execute(select(_TABLE).order_by(_TABLE.c.name))]


@pytest.mark.parametrize("count", [1, 3, 4, 17, 64, 257, 341])
def test_the_same_rows_are_stored(count: int) -> None:
    assert _stored(count, by_one_statement=True) == _stored(count, by_one_statement=False)


def test_a_row_whose_key_is_known_is_replaced_only_if_asked_for() -> None:
    with create_engine("sqlite://").begin() as connection:
        _TABLE.create(connection)
        insert_rows(connection, _TABLE, _rows(5, value=1))
        insert_rows(connection, _TABLE, _rows(7, value=None), "replace")
        values = connection.execute(select(_TABLE.c.value)).scalars().all()
        assert list(values) == [None] * 7
        with pytest.raises(Exception, match="UNIQUE"):
            insert_rows(connection, _TABLE, _rows(1))


def test_a_row_whose_key_is_known_stays_as_it_is_if_that_is_asked_for() -> None:
    with create_engine("sqlite://").begin() as connection:
        _TABLE.create(connection)
        insert_rows(connection, _TABLE, _rows(5, value=1))
        insert_rows(connection, _TABLE, _rows(7, value=2), "keep")
        values = connection.execute(select(_TABLE.c.value).order_by(_TABLE.c.name)).scalars().all()
        assert list(values) == [1] * 5 + [2] * 2


def test_a_moment_without_a_zone_is_refused_as_elsewhere() -> None:
    rows = _rows(4)
    rows[2]["at"] = NOON.replace(tzinfo=None)
    with create_engine("sqlite://").begin() as connection:
        _TABLE.create(connection)
        with pytest.raises(ValueError, match="no time zone"):
            insert_rows(connection, _TABLE, rows)
