"""Deletes old telemetry, decisions and sessions, and learns the travel time factors."""

from server.loops.periodic_task import PeriodicTask
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.record import retention, travel_time_factors

PERIOD_S = 3600.0


class RetentionLoop:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self._task = PeriodicTask("retention", self.run_once, PERIOD_S)

    async def run(self) -> None:
        await self._task.run()

    async def run_once(self) -> None:
        await self._transactions.run(retention.forget_old)
        await self._transactions.run(travel_time_factors.learn)
