"""Messages between replicas: nobody may depend on having seen one."""

from typing import Protocol


class Subscription(Protocol):
    """An asynchronous iterator of (topic, payload); the oldest are dropped for who cannot keep up."""

    def __aiter__(self) -> "Subscription": ...

    async def __anext__(self) -> tuple[str, bytes]: ...

    async def close(self) -> None: ...


class Bus(Protocol):
    """Disposable messages between replicas: whoever misses one reads the store."""

    async def publish(self, topic: str, payload: bytes) -> None: ...

    async def subscribe(self, pattern: str) -> Subscription:
        """pattern: topic levels divided by `/`, `*` for one level, `>` for the rest."""
        ...

    async def close(self) -> None: ...
