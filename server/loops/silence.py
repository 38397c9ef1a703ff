"""Notices vehicles that are silent."""

from server.supervision.standing_tasks import PeriodicTask
from server.usecases.fleet import vehicle_sessions
from server.usecases.ports.unit_of_work import Transactions

PERIOD_S = 1.0


class SilenceMonitor:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self.task = PeriodicTask("silence", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        await self._transactions.run(vehicle_sessions.note_silence)
