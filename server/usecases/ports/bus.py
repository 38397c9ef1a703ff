"""Messages between replicas. No reader may depend on having received one."""

from typing import Protocol


class Subscription(Protocol):
    """An asynchronous iterator of (topic, payload). The oldest are dropped if the reader is too slow."""

    def __aiter__(self) -> "Subscription": ...

    async def __anext__(self) -> tuple[str, bytes]: ...

    async def close(self) -> None: ...


class Bus(Protocol):
    """Messages between replicas that may be lost: a reader that misses one reads the store."""

    async def publish(self, topic: str, payload: bytes) -> None:
        """Never raises: what is published has happened already, whether it is told or not."""
        ...

    def wants(self, topic: str) -> bool:
        """False if it is certain that a message on the topic has no reader: it need not be made."""
        ...

    async def subscribe(self, pattern: str) -> Subscription:
        """pattern: topic levels divided by `/`, `*` for one level, `>` for the rest."""
        ...

    async def close(self) -> None: ...
