"""The base of every standing task: work that runs every period, or sooner after a message."""

import asyncio
from collections.abc import Awaitable, Callable

import structlog

from server.domain.errors import DomainError
from server.usecases.ports.bus import Bus, Subscription

log = structlog.get_logger("loops")


class PeriodicTask:
    """Runs `work` every period_s, and soon after a message on one of the topics.

    A refusal (DomainError) is logged, and the next period comes all the same. Any other exception is a defect
    and ends the task.
    """

    def __init__(
        self,
        name: str,
        work: Callable[[], Awaitable[None]],
        period_s: float,
        bus: Bus | None = None,
        topics: tuple[str, ...] = (),
    ) -> None:
        self._name = name
        self._work = work
        self._period_s = period_s
        self._bus = bus
        self._topics = topics
        self._woken = asyncio.Event()

    async def run(self) -> None:
        listeners = []
        if self._bus is not None:
            for topic in self._topics:
                subscription = await self._bus.subscribe(topic)
                listeners.append(asyncio.ensure_future(self._listen(subscription)))
        try:
            while True:
                await self._once()
                await self._rest()
        finally:
            for listener in listeners:
                listener.cancel()

    async def _once(self) -> None:
        self._woken.clear()
        try:
            await self._work()
        except DomainError as error:
            log.warning("loop.refused", loop=self._name, code=error.code, detail=error.detail)

    async def _rest(self) -> None:
        try:
            async with asyncio.timeout(self._period_s):
                await self._woken.wait()
        except TimeoutError:
            return

    async def _listen(self, subscription: Subscription) -> None:
        async for _topic, _payload in subscription:
            self._woken.set()
