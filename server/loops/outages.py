"""Incidents of the server itself: which of its standing tasks fail, and since when."""

from server.supervision.standing_tasks import PeriodicTask
from server.supervision.supervisor import Supervisor
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.record.outages import record_outages

PERIOD_S = 2.0


class OutageRecorder:
    def __init__(self, transactions: Transactions, supervisor: Supervisor, server_name: str) -> None:
        self._transactions, self._supervisor, self._server_name = transactions, supervisor, server_name
        # After a start, incidents of the process before may be open.
        self._has_open = True
        self.task = PeriodicTask("outages", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        """Write only if something has changed: while all is well there is nothing to store."""
        past, present = self._supervisor.past_outages(), self._supervisor.present_outages()
        if not (past or present or self._has_open):
            return
        await self._transactions.run(lambda uow: record_outages(uow, self._server_name, past, present))
        self._supervisor.recorded(past)
        self._has_open = bool(present)
