"""Tells browsers of the rides that they asked for: each notice once, soon after it has become true."""

import asyncio
from collections import Counter
from collections.abc import Sequence
from urllib.parse import urlsplit

import structlog

from server.domain.rides.notices import PushSubscription
from server.supervision.standing_tasks import PeriodicTask
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.push import PushAnswer, PushSender
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.rides import notices
from server.usecases.rides.notices import PER_SERVICE_MAX, ClaimedNotice, DueNotice

PERIOD_S = 2.0

log = structlog.get_logger("notices")


class RideNotices:
    def __init__(self, transactions: Transactions, sender: PushSender, clock: Clock) -> None:
        self._transactions, self._sender, self._clock = transactions, sender, clock
        self.task = PeriodicTask("ride notices", self.run_once, PERIOD_S)

    async def run_once(self) -> None:
        """Replicas may run it side by side: a notice is claimed by one of them."""
        found, over = await self._transactions.read(notices.due)
        found = _spread(found)
        if not found and not over:
            return
        claimed = await self._transactions.run(lambda uow: notices.claim(uow, found, over))
        answers = await asyncio.gather(*(self._send(one) for one in claimed))
        if answers:
            await self._transactions.run(lambda uow: notices.record_answers(uow, answers))

    async def _send(self, claimed: ClaimedNotice) -> tuple[DueNotice, PushAnswer]:
        subscription, notice = claimed.due.subscription, claimed.due.notice
        answer = await self._sender.send(subscription, claimed.message, self._clock.now())
        if answer.failure:
            log.info(
                "notice.failed",
                ride_id=subscription.ride_id,
                kind=notice.kind,
                service=_service(subscription),
                failure=answer.failure,
            )
        return claimed.due, answer


def _spread(found: Sequence[DueNotice]) -> tuple[DueNotice, ...]:
    """At most PER_SERVICE_MAX for each push service; the others wait for the next cycle."""
    taken: Counter[str] = Counter()
    kept = []
    for one in found:
        service = _service(one.subscription)
        if taken[service] < PER_SERVICE_MAX:
            taken[service] += 1
            kept.append(one)
    return tuple(kept)


def _service(subscription: PushSubscription) -> str:
    """The rest of the address is a secret."""
    return urlsplit(subscription.endpoint).netloc
