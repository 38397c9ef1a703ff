"""Notices vehicles that are silent, and ends the quarantine of those that keep to the protocol again."""

from collections.abc import Callable
from functools import partial

from server.supervision.standing_tasks import PeriodicTask
from server.supervision.steps import run_steps
from server.usecases.fleet import quarantine, vehicle_sessions
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

PERIOD_S = 1.0


class SilenceMonitor:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self.task = PeriodicTask("silence", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        works: tuple[Callable[[UnitOfWork], object], ...] = (vehicle_sessions.note_silence, quarantine.review)
        await run_steps(partial(self._transactions.run, work) for work in works)
