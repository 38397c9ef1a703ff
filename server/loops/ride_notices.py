"""Tells browsers of the rides that they asked for: each notice once, soon after it has become true.

Each push service has a task of its own: one that answers slowly holds up its own notices, and no others.
"""

import asyncio
from collections import Counter
from collections.abc import Sequence
from urllib.parse import urlsplit

import structlog

from server.domain.rides.notices import PushSubscription
from server.supervision.standing_tasks import Cycles, PeriodicTask
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.push import PushAnswer, PushSender
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.rides import notices
from server.usecases.rides.notices import PER_SERVICE_MAX, ClaimedNotice, DueNotice

PERIOD_S = 2.0
# A cycle waits so long for answers; slower ones are taken up when they come.
ANSWERS_WITHIN_S = 1.0

log = structlog.get_logger("notices")


class RideNotices:
    def __init__(self, transactions: Transactions, sender: PushSender, clock: Clock) -> None:
        self._transactions, self._sender, self._clock = transactions, sender, clock
        # By push service.
        self._sending: dict[str, asyncio.Task[None]] = {}
        self.task = _NoticeTask(self)

    async def run_once(self) -> None:
        """Replicas may run it side by side: a notice is claimed by one of them."""
        self._take_up_ended()
        found, over = await self._transactions.read(notices.due)
        free = _spread([one for one in found if _service(one.subscription) not in self._sending])
        if free or over:
            claimed = await self._transactions.run(lambda uow: notices.claim(uow, free, over))
            by_service: dict[str, list[ClaimedNotice]] = {}
            for one in claimed:
                by_service.setdefault(_service(one.due.subscription), []).append(one)
            for service, group in by_service.items():
                self._sending[service] = asyncio.create_task(self._send_all(group))
        if self._sending:
            await asyncio.wait(self._sending.values(), timeout=ANSWERS_WITHIN_S)
        self._take_up_ended()

    async def end(self) -> None:
        """Give up what is not answered yet: it stays claimed, as after a crash."""
        sending = list(self._sending.values())
        self._sending.clear()
        for task in sending:
            task.cancel()
        await asyncio.gather(*sending, return_exceptions=True)

    def _take_up_ended(self) -> None:
        """Raises what ended a task, e.g. StoreFailure."""
        for service, task in list(self._sending.items()):
            if task.done():
                del self._sending[service]
                task.result()

    async def _send_all(self, claimed: Sequence[ClaimedNotice]) -> None:
        answers = await asyncio.gather(*(self._send(one) for one in claimed))
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


class _NoticeTask(PeriodicTask):
    """Ends what is being sent when it is stopped."""

    def __init__(self, notices: RideNotices) -> None:
        super().__init__("ride notices", notices.run_once, PERIOD_S)
        self._notices = notices

    async def run(self, cycles: Cycles) -> None:
        try:
            await super().run(cycles)
        finally:
            await self._notices.end()


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
