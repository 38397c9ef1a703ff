"""Telemetry and sessions are kept for a bounded time; events, rides and runs are kept. Travel times by the
hour are learnt anew as often."""

from server.loops.pulse import Pulse
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.record import paces, retention

PERIOD_S = 3600.0


class Retention:
    def __init__(self, transactions: Transactions) -> None:
        self._transactions = transactions
        self._pulse = Pulse("retention", self.beat, PERIOD_S)

    async def run(self) -> None:
        await self._pulse.run()

    async def beat(self) -> None:
        await self._transactions.run(retention.forget_old)
        await self._transactions.run(paces.learn)
