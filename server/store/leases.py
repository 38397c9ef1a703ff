"""Leases: one holder at a time, each new holder with a higher fencing token."""

from datetime import datetime, timedelta

from server.store import tables
from server.store.repository import Repository

_lease = tables.leases.c
# Of a lease's length: the clocks of two servers differ by less.
CLOCKS_APART = 2.0


class SqlLeaseRepository(Repository):
    def take(self, name: str, holder: str, now: datetime, seconds: float) -> int | None:
        self._add_missing(tables.leases, [{"name": name, "holder": "", "token": 0, "expires_at": now}])
        row = self._find(tables.leases, name=name)
        if row is None:
            raise LookupError(f"lease {name} vanished inside a transaction")
        # A lease that ends much later than any begun now was taken by a clock that has been set back since.
        is_live = now < row.expires_at <= now + timedelta(seconds=CLOCKS_APART * seconds)
        if row.holder != holder and is_live:
            return None
        token = int(row.token) if row.holder == holder and is_live else int(row.token) + 1
        self._put(
            tables.leases,
            {"name": name, "holder": holder, "token": token, "expires_at": now + timedelta(seconds=seconds)},
        )
        return token

    def token(self, name: str) -> int:
        row = self._find(tables.leases, name=name)
        return 0 if row is None else int(row.token)
