"""Deletes old telemetry, decisions and sessions, and learns the travel time factors."""

from functools import partial

from server.supervision.standing_tasks import PeriodicTask
from server.supervision.steps import run_steps
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.record import retention, travel_time_factors

PERIOD_S = 3600.0


class RetentionLoop:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self.task = PeriodicTask("retention", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        works = (retention.forget_old, travel_time_factors.learn)
        await run_steps(partial(self._transactions.run, work) for work in works)
