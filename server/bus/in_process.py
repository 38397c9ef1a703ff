"""The bus of a single server: subscribers in this process, on this event loop."""

import asyncio
from collections import deque

from server.bus.topics import matches

QUEUE_MAX = 4096
TOPICS_KEPT = 100_000


class LocalSubscription:
    """Messages for one subscriber. The oldest are dropped when it falls behind; `dropped` counts them."""

    def __init__(self, bus: "InProcessBus", pattern: str) -> None:
        self.pattern = pattern
        self.dropped = 0
        self._bus = bus
        self._messages: deque[tuple[str, bytes]] = deque()
        self._waiting: asyncio.Future[None] | None = None
        self._closed = False

    def deliver(self, topic: str, payload: bytes) -> None:
        if len(self._messages) == QUEUE_MAX:
            self._messages.popleft()
            self.dropped += 1
        self._messages.append((topic, payload))
        self._wake()

    def __aiter__(self) -> "LocalSubscription":
        return self

    async def __anext__(self) -> tuple[str, bytes]:
        while not self._messages:
            if self._closed:
                raise StopAsyncIteration
            self._waiting = asyncio.get_running_loop().create_future()
            await self._waiting
        return self._messages.popleft()

    async def close(self) -> None:
        self._closed = True
        self._bus.forget(self)
        self._wake()

    def _wake(self) -> None:
        if self._waiting is not None and not self._waiting.done():
            self._waiting.set_result(None)


class InProcessBus:
    def __init__(self) -> None:
        self._subscriptions: list[LocalSubscription] = []
        # Whom a message on a topic is for: most topics are published again and again.
        self._receivers: dict[str, tuple[LocalSubscription, ...]] = {}

    async def publish(self, topic: str, payload: bytes) -> None:
        for subscription in self._receivers_of(topic):
            subscription.deliver(topic, payload)

    def wants(self, topic: str) -> bool:
        return bool(self._receivers_of(topic))

    def _receivers_of(self, topic: str) -> tuple[LocalSubscription, ...]:
        receivers = self._receivers.get(topic)
        return self._find_receivers(topic) if receivers is None else receivers

    def _find_receivers(self, topic: str) -> tuple[LocalSubscription, ...]:
        if len(self._receivers) >= TOPICS_KEPT:
            self._receivers.clear()
        found = tuple(one for one in self._subscriptions if matches(one.pattern, topic))
        self._receivers[topic] = found
        return found

    async def subscribe(self, pattern: str) -> LocalSubscription:
        subscription = LocalSubscription(self, pattern)
        self._subscriptions.append(subscription)
        self._receivers.clear()
        return subscription

    async def close(self) -> None:
        for subscription in list(self._subscriptions):
            await subscription.close()

    def forget(self, subscription: LocalSubscription) -> None:
        if subscription in self._subscriptions:
            self._subscriptions.remove(subscription)
            self._receivers.clear()
