"""Notices vehicles that are silent, and ends the quarantine of those that keep to the protocol again."""

from server.supervision.standing_tasks import PeriodicTask
from server.supervision.steps import run_together
from server.usecases.fleet import quarantine, vehicle_sessions
from server.usecases.ports.unit_of_work import Transactions

PERIOD_S = 1.0


class SilenceMonitor:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self.task = PeriodicTask("silence", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        await run_together(self._transactions.run, (vehicle_sessions.note_silence, quarantine.review))
