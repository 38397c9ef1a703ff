"""Objects made of rows, kept from one transaction of a writer to its next one.

Reading the fleet for every booking takes longer than deciding it. Every write changes the cache too. A failed
transaction takes its changes back. After a commit by another writer, everything is read again.
"""

from collections.abc import Callable, Hashable
from typing import Any, Final

_ABSENT: Final = object()
_NO_VERSION: Final = -1
Rows = dict[Any, Any]


class RowCache:
    """Tables of immutable objects. Belongs to one thread and one connection."""

    def __init__(self) -> None:
        self._tables: dict[str, Rows] = {}
        self._undo: list[Callable[[], None]] = []
        self._version = _NO_VERSION

    def begin(self, found: int, made: int) -> None:
        """Begin a transaction: forget everything if another writer has written since the last one.

        found, made  the version of the database, and what the commit of this transaction makes of it
        """
        if found != self._version:
            self.forget()
        self._version = made
        self._undo.clear()

    def is_at(self, version: int) -> None:
        """The transaction was rolled back, and all that it changed here has been taken back."""
        self._version = version

    def forget(self) -> None:
        self._tables.clear()
        self._undo.clear()
        self._version = _NO_VERSION

    def mark(self) -> int:
        """What to give to `take_back` if what follows fails."""
        return len(self._undo)

    def take_back(self, mark: int) -> None:
        while len(self._undo) > mark:
            self._undo.pop()()

    def has(self, name: str) -> bool:
        """The table is loaded."""
        return name in self._tables

    def table(self, name: str, load: Callable[[], Rows] | None = None) -> Rows:
        """The table, which must not be changed. load: fills it if it is not loaded yet."""
        found = self._tables.get(name)
        if found is None:
            found = self._tables[name] = load() if load else {}
            self._undo.append(lambda: self._drop(name))
        return found

    def put(self, name: str, key: Hashable, value: object) -> None:
        """Change a row of a loaded table; a table that is not loaded will be read later."""
        rows = self._tables.get(name)
        if rows is not None:
            self._keep_old(rows, key)
            rows[key] = value

    def remove(self, name: str, key: Hashable, value: Any = _ABSENT) -> None:
        """Remove a row of a loaded table; with a value, only the row that has it."""
        rows = self._tables.get(name)
        if rows is not None and key in rows and value in (_ABSENT, rows[key]):
            self._keep_old(rows, key)
            del rows[key]

    def unload(self, name: str) -> None:
        """Read this table again when it is needed."""
        rows = self._tables.pop(name, None)
        if rows is not None:
            # What is loaded from now on in this transaction is dropped before this is put back.
            self._undo.append(lambda: self._tables.__setitem__(name, rows))

    def _keep_old(self, rows: Rows, key: Hashable) -> None:
        old = rows.get(key, _ABSENT)
        self._undo.append(lambda: _put_back(rows, key, old))

    def _drop(self, name: str) -> None:
        self._tables.pop(name, None)


def _put_back(rows: Rows, key: Hashable, old: object) -> None:
    if old is _ABSENT:
        rows.pop(key, None)
    else:
        rows[key] = old
