"""The two kinds of standing tasks: work that is due every period, and the reader of a topic."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Protocol

import structlog

from server.domain.errors import DomainError, StoreFailure
from server.usecases.ports.bus import Bus, Subscription

log = structlog.get_logger("supervision")


class Cycles(Protocol):
    """Takes the result of each cycle of a standing task."""

    def succeeded(self) -> None: ...

    def input_failed(self, error: Exception) -> None:
        """One input could not be handled; the task goes on with the next one."""
        ...


class StandingTask(Protocol):
    """Work that goes on for as long as the server runs.

    period_s  the time between cycles; None for a task that waits for messages
    """

    @property
    def name(self) -> str: ...

    @property
    def period_s(self) -> float | None: ...

    async def run(self, cycles: Cycles) -> None:
        """Run until cancelled. Raises what a cycle raised; the supervisor then runs it again."""
        ...


class SubscriptionEnded(ConnectionError):
    """The bus has closed a subscription that is still needed."""


class PeriodicTask:
    """Runs `work` every period_s, and soon after `wake` or a message on one of the topics.

    A refusal (DomainError) is logged, and the next period comes all the same. A failure of the database is no
    refusal.
    """

    def __init__(
        self,
        name: str,
        work: Callable[[], Awaitable[None]],
        period_s: float,
        bus: Bus | None = None,
        topics: tuple[str, ...] = (),
    ) -> None:
        self.name = name
        self.period_s = period_s
        self._work = work
        self._bus = bus
        self._topics = topics
        self._woken = asyncio.Event()

    def wake(self) -> None:
        """Run the next cycle as soon as the present one has ended."""
        self._woken.set()

    async def run(self, cycles: Cycles) -> None:
        listeners: list[asyncio.Task[None]] = []
        try:
            if self._bus is not None:
                for topic in self._topics:
                    subscription = await self._bus.subscribe(topic)
                    listeners.append(asyncio.ensure_future(self._listen(subscription)))
            while True:
                await self._once()
                cycles.succeeded()
                await self._rest(listeners)
        finally:
            for listener in listeners:
                listener.cancel()

    async def _once(self) -> None:
        self._woken.clear()
        try:
            await self._work()
        except StoreFailure:
            raise
        except DomainError as error:
            log.warning("task.refused", task=self.name, code=error.code, detail=error.detail)

    async def _rest(self, listeners: list[asyncio.Task[None]]) -> None:
        """Until the period is over or something wakes the task. Raises what ended a listener."""
        waking = asyncio.ensure_future(self._woken.wait())
        try:
            done, _ = await asyncio.wait(
                (waking, *listeners), timeout=self.period_s, return_when=asyncio.FIRST_COMPLETED
            )
        finally:
            waking.cancel()
        for listener in done - {waking}:
            listener.result()

    async def _listen(self, subscription: Subscription) -> None:
        try:
            async for _topic, _payload in subscription:
                self._woken.set()
        finally:
            await subscription.close()
        raise SubscriptionEnded(f"{self.name}: a subscription has ended")


class TopicReader:
    """Hands each message on a topic to `take`. A message that it cannot take stops no other one."""

    period_s: float | None = None

    def __init__(self, name: str, bus: Bus, topic: str, take: Callable[[str, bytes], None]) -> None:
        self.name = name
        self._bus, self._topic, self._take = bus, topic, take
        self._subscription: Subscription | None = None

    async def subscribe(self) -> None:
        """From here on no message is missed; `run` hands them on."""
        if self._subscription is None:
            self._subscription = await self._bus.subscribe(self._topic)

    async def run(self, cycles: Cycles) -> None:
        await self.subscribe()
        assert self._subscription is not None
        subscription = self._subscription
        cycles.succeeded()
        try:
            async for topic, payload in subscription:
                try:
                    self._take(topic, payload)
                except Exception as error:
                    cycles.input_failed(error)
        finally:
            self._subscription = None
            await subscription.close()
        raise SubscriptionEnded(f"{self.name}: the subscription of {self._topic} has ended")
