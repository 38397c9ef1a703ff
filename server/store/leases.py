"""Leases: one holder at a time, each new holder with a higher fencing token."""

from datetime import datetime, timedelta

from server.store import tables
from server.store.repository import Repository

# Of a lease's length: the clocks of two servers differ by less.
CLOCKS_APART = 2.0
# Of a lease's length: its holder writes it again when less is left.
RENEWED_BELOW = 0.5


class SqlLeaseRepository(Repository):
    def take(self, name: str, holder: str, now: datetime, seconds: float) -> int | None:
        row = self._find(tables.leases, name=name)
        if row is None:
            self._write(name, holder, 1, now, seconds)
            return 1
        # A lease that ends much later than any begun now was taken by a clock that has been set back since.
        is_live = now < row.expires_at <= now + timedelta(seconds=CLOCKS_APART * seconds)
        if row.holder != holder and is_live:
            return None
        keeps = row.holder == holder and is_live
        if keeps and row.expires_at - now > timedelta(seconds=RENEWED_BELOW * seconds):
            return int(row.token)
        token = int(row.token) if keeps else int(row.token) + 1
        self._write(name, holder, token, now, seconds)
        return token

    def token(self, name: str) -> int:
        row = self._find(tables.leases, name=name)
        return 0 if row is None else int(row.token)

    def _write(self, name: str, holder: str, token: int, now: datetime, seconds: float) -> None:
        ends = now + timedelta(seconds=seconds)
        self._put(tables.leases, {"name": name, "holder": holder, "token": token, "expires_at": ends})
