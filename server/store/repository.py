"""The base of every repository: a connection inside a transaction, on one campus."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from sqlalchemy import (
    Connection,
    Delete,
    Insert,
    Row,
    Select,
    Table,
    Update,
    and_,
    bindparam,
    delete,
    insert,
    select,
    update,
)
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.sql import ColumnElement

from server.store.writing.campus_lock import CampusLock
from server.store.writing.many_rows import insert_rows, insert_values

AnyRow = Row[Any]
# Numbers of rows for which SQLAlchemy's own statement is quicker than those of `many_rows`.
_FEW = (2, 3)
DialectInsert = postgresql.Insert | sqlite.Insert


@cache
def _finding(table: Table, names: tuple[str, ...]) -> Select[Any]:
    return select(table).where(*(table.c[name] == bindparam(name) for name in ("campus_id", *names)))


@cache
def _changing(table: Table, values: tuple[str, ...], names: tuple[str, ...]) -> Update:
    equal = (table.c[name] == bindparam(f"where_{name}") for name in ("campus_id", *names))
    return update(table).where(*equal).values({name: bindparam(name) for name in values})


@cache
def _removing(table: Table, names: tuple[str, ...]) -> Delete:
    return delete(table).where(*(table.c[name] == bindparam(name) for name in ("campus_id", *names)))


@cache
def _inserting(table: Table) -> Insert:
    return insert(table)


@cache
def _adding(dialect: str, table: Table, names: tuple[str, ...]) -> DialectInsert:
    return _new_row(dialect, table, names).on_conflict_do_nothing()


def _new_row(dialect: str, table: Table, names: tuple[str, ...]) -> DialectInsert:
    new = dialect_insert(dialect, table)
    return new.values({name: bindparam(name) for name in ("campus_id", *names)})


@cache
def _putting(dialect: str, table: Table, names: tuple[str, ...]) -> DialectInsert:
    keys = [column.name for column in table.primary_key.columns]
    new = _new_row(dialect, table, names)
    changed = {name: new.excluded[name] for name in names if name not in keys}
    return new.on_conflict_do_update(index_elements=keys, set_=changed)


def dialect_insert(dialect: str, table: Table) -> DialectInsert:
    """An insert that can say what happens to a row whose key is there already."""
    return postgresql.insert(table) if dialect == "postgresql" else sqlite.insert(table)


class Repository:
    """lock: of a writing transaction; None for one that reads. Reading takes no lock of its own."""

    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock | None) -> None:
        self._connection = connection
        self._campus_id = campus_id
        self._lock = lock

    @property
    def _is_sqlite(self) -> bool:
        return self._connection.dialect.name == "sqlite"

    def _one(self, table: Table, *conditions: ColumnElement[bool]) -> AnyRow | None:
        statement = self._select(table, *conditions)
        return self._connection.execute(statement).first()

    def _many(self, statement: Select[Any]) -> Sequence[AnyRow]:
        return self._connection.execute(statement).all()

    def _find(self, table: Table, **equal: object) -> AnyRow | None:
        """The row whose columns equal these. Its statement is made once, which saves half the time."""
        statement = _finding(table, tuple(equal))
        return self._connection.execute(statement, {"campus_id": self._campus_id, **equal}).first()

    def _change(self, table: Table, values: Mapping[str, object], **equal: object) -> int:
        """Change the rows whose columns equal these; how many there were. Made once, like `_find`."""
        named = {f"where_{name}": value for name, value in equal.items()}
        self._require_lock()
        statement = _changing(table, tuple(values), tuple(equal))
        done = self._connection.execute(statement, {**values, "where_campus_id": self._campus_id, **named})
        return int(done.rowcount)

    def _remove_all(self, table: Table, rows: Sequence[Mapping[str, object]]) -> None:
        """Delete the rows whose columns equal these; each names the same columns. Made once, like `_find`."""
        if rows:
            self._require_lock()
            statement = _removing(table, tuple(rows[0]))
            self._connection.execute(statement, [{"campus_id": self._campus_id, **row} for row in rows])

    def _require_lock(self) -> None:
        assert self._lock is not None, "written in a transaction that only reads"
        self._lock.require(self._campus_id)

    def _select(self, table: Table, *conditions: ColumnElement[bool]) -> Select[Any]:
        return select(table).where(table.c.campus_id == self._campus_id, *conditions)

    def _insert(self, table: Table, values: Mapping[str, object]) -> None:
        self._insert_all(table, [values])

    def _insert_all(self, table: Table, rows: Sequence[Mapping[str, object]]) -> None:
        self._require_lock()
        owned = [{"campus_id": self._campus_id, **row} for row in rows]
        if self._is_sqlite and len(owned) not in _FEW:
            insert_rows(self._connection, table, owned)
        else:
            self._connection.execute(_inserting(table), owned)

    def _insert_values(
        self, table: Table, names: tuple[str, ...], values: Sequence[Sequence[object]]
    ) -> None:
        """Insert rows of numbers and texts, given in the order of the names; the campus is added."""
        self._require_lock()
        names = ("campus_id", *names)
        owned = [(self._campus_id, *row) for row in values]
        if self._is_sqlite:
            insert_values(self._connection, table, names, owned)
        else:
            rows = [dict(zip(names, row, strict=True)) for row in owned]
            self._connection.execute(_inserting(table), rows)

    def _put(self, table: Table, values: Mapping[str, object]) -> None:
        """Insert the row, or replace the one of the same key."""
        self._put_all(table, [values])

    def _put_all(self, table: Table, rows: Sequence[Mapping[str, object]]) -> None:
        """`_put` for rows of different keys and the same columns, in one statement."""
        if rows:
            self._require_lock()
            owned = [{"campus_id": self._campus_id, **row} for row in rows]
            if self._is_sqlite and len(owned) not in _FEW:
                insert_rows(self._connection, table, owned, "replace")
                return
            statement = _putting(self._connection.dialect.name, table, tuple(rows[0]))
            self._connection.execute(statement, owned)

    def _add_missing(self, table: Table, rows: Sequence[Mapping[str, object]]) -> None:
        """Insert the rows whose keys are new. They have the same columns."""
        if rows:
            self._require_lock()
            owned = [{"campus_id": self._campus_id, **row} for row in rows]
            if self._is_sqlite and len(owned) not in _FEW:
                insert_rows(self._connection, table, owned, "keep")
                return
            statement = _adding(self._connection.dialect.name, table, tuple(rows[0]))
            self._connection.execute(statement, owned)

    def _update(self, table: Table, values: Mapping[str, object], *conditions: ColumnElement[bool]) -> int:
        """How many rows were changed."""
        self._require_lock()
        done = self._connection.execute(
            table.update().where(and_(table.c.campus_id == self._campus_id, *conditions)).values(**values)
        )
        return int(done.rowcount)

    def _delete(self, table: Table, *conditions: ColumnElement[bool]) -> int:
        self._require_lock()
        done = self._connection.execute(
            table.delete().where(and_(table.c.campus_id == self._campus_id, *conditions))
        )
        return int(done.rowcount)
