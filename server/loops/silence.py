"""Notices vehicles that are silent."""

from server.loops.periodic_task import PeriodicTask
from server.usecases.fleet import vehicle_sessions
from server.usecases.ports.unit_of_work import Transactions

PERIOD_S = 1.0


class SilenceMonitor:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self._task = PeriodicTask("silence", self.run_once, PERIOD_S)

    async def run(self) -> None:
        await self._task.run()

    async def run_once(self) -> None:
        await self._transactions.run(vehicle_sessions.note_silence)
