"""Many rows in one statement of SQLite, for what comes thousands of times a second.

`executemany` runs the statement once for each row. Each run gives up Python's interpreter lock, which the
event loop then holds for up to a switch interval: a hundred rows would wait a hundred times.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from itertools import chain
from typing import Any, Literal

from sqlalchemy import Connection, Dialect, Table

# The sizes of the statements: each has its own text, which SQLite prepares once.
_SIZES = (256, 64, 16, 4, 1)

Rows = Sequence[Mapping[str, object]]
# What becomes of a row whose key is there already: an error, it gets the new values, or it stays as it is.
Known = Literal["refuse", "replace", "keep"]
_Processor = Callable[[Any], Any]


def insert_rows(connection: Connection, table: Table, rows: Rows, known: Known = "refuse") -> None:
    """Insert rows that have the same columns. Those that replace others have different keys."""
    names = tuple(rows[0])
    processors = _processors(connection.dialect, table, names)
    values = [_values(row, names, processors) for row in rows]
    insert_values(connection, table, names, values, known)


def insert_values(
    connection: Connection,
    table: Table,
    names: tuple[str, ...],
    values: Sequence[Sequence[object]],
    known: Known = "refuse",
) -> None:
    """Insert rows whose values, in the order of the names, are those that the driver stores."""
    at = 0
    for size in _SIZES:
        while len(values) - at >= size:
            parameters = tuple(chain.from_iterable(values[at : at + size]))
            connection.exec_driver_sql(_statement(table, names, size, known), parameters)
            at += size


def _values(
    row: Mapping[str, object], names: Iterable[str], processors: Sequence[_Processor | None]
) -> list[object]:
    return [
        row[name] if process is None else process(row[name])
        for name, process in zip(names, processors, strict=True)
    ]


@cache
def _statement(table: Table, names: tuple[str, ...], size: int, known: Known) -> str:
    one = f"({', '.join('?' * len(names))})"
    text = f"INSERT INTO {table.name} ({', '.join(names)}) VALUES {', '.join([one] * size)}"
    if known == "refuse":
        return text
    if known == "keep":
        return f"{text} ON CONFLICT DO NOTHING"
    keys = [column.name for column in table.primary_key.columns]
    changes = ", ".join(f"{name} = excluded.{name}" for name in names if name not in keys)
    return f"{text} ON CONFLICT ({', '.join(keys)}) DO UPDATE SET {changes}"


@cache
def _processors(dialect: Dialect, table: Table, names: tuple[str, ...]) -> tuple[_Processor | None, ...]:
    return tuple(table.c[name].type.dialect_impl(dialect).bind_processor(dialect) for name in names)
