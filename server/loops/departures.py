"""Timetable departures get their shuttles in time."""

from server.supervision.standing_tasks import PeriodicTask
from server.usecases.fleet import departures
from server.usecases.ports.unit_of_work import Transactions

LEASE = "departures"
PERIOD_S = 5.0
LEASE_S = 20.0


class DepartureScheduler:
    def __init__(self, transactions: Transactions, holder: str) -> None:
        self._transactions = transactions
        self._holder = holder
        self.task = PeriodicTask("departures", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        """Under the lease, in one transaction with it: only one replica enters a day's departures."""
        await self._transactions.run(
            lambda uow: (
                departures.plan_departures(uow)
                if uow.leases.take(LEASE, self._holder, uow.now, LEASE_S) is not None
                else ()
            )
        )
