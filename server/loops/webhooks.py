"""Delivers recorded events to webhooks: in order, at least once, again after growing pauses."""

import asyncio
import random

from server.supervision.standing_tasks import PeriodicTask
from server.usecases.ports.clock_and_ids import Clock, Ids
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.ports.webhooks import WebhookSender
from server.usecases.record.webhooks import deliveries
from server.usecases.record.webhooks.deliveries import KEY_GONE, DeliveryResult, DueDelivery

LEASE = "webhooks"
PERIOD_S = 1.0
LEASE_S = 60.0
# A slow address is left after so long and is continued in the next cycle, well inside the lease.
DELIVERY_S_MAX = 20.0
TOGETHER_MAX = 16


class WebhookDeliveries:
    def __init__(
        self, transactions: Transactions, sender: WebhookSender, clock: Clock, ids: Ids, holder: str
    ) -> None:
        self._transactions, self._sender, self._clock, self._ids = transactions, sender, clock, ids
        self._holder = holder
        self._slots = asyncio.Semaphore(TOGETHER_MAX)
        self.task = PeriodicTask("webhooks", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        """One replica at a time; a second one would send the same messages once more."""
        if not await self._transactions.read(deliveries.due):
            return
        held = await self._transactions.run(
            lambda uow: uow.leases.take(LEASE, self._holder, uow.now, LEASE_S)
        )
        if held is None:
            return
        # Read again: the holder before may have moved the cursors meanwhile.
        due = await self._transactions.read(deliveries.due)
        results = await asyncio.gather(*(self._deliver(one) for one in due))
        chance = random.Random(self._ids.seed()).random()
        await self._transactions.run(lambda uow: deliveries.record_results(uow, results, chance))
        if any(one.delivered_to is not None and not one.failure for one in results):
            self.task.wake()

    async def _deliver(self, delivery: DueDelivery) -> DeliveryResult:
        """In order: a message that does not arrive keeps the later ones waiting."""
        webhook_id, url = delivery.webhook.webhook_id, delivery.webhook.url
        delivered_to = delivery.passed_to or None
        if delivery.messages and not delivery.keys:
            return DeliveryResult(webhook_id, None, KEY_GONE)
        loop = asyncio.get_running_loop()
        async with self._slots:
            until_s = loop.time() + DELIVERY_S_MAX
            for message in delivery.messages:
                headers = delivery.headers(message, self._clock.now())
                answer = await self._sender.send(url, headers, message.body)
                if answer.failure:
                    return DeliveryResult(webhook_id, delivered_to, answer.failure, answer.is_gone)
                delivered_to = message.number
                if loop.time() > until_s:
                    break
        return DeliveryResult(webhook_id, delivered_to)
