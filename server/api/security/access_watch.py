"""Ends connections whose session or token has ended: revoked, signed out or expired."""

import asyncio
from collections.abc import Awaitable, Callable
from datetime import datetime

from server.domain.errors import DomainError, StoreFailure
from server.supervision.standing_tasks import TopicReader
from server.supervision.supervisor import Supervisor
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock

# Messages on the bus may be lost: the store is asked so often in any case.
RECHECK_EVERY_S = 30.0

# Reads the session or token again. Returns when it expires; raises the refusal.
AccessCheck = Callable[[], Awaitable[datetime]]


class AccessWatch:
    """`start` once; then each connection waits in `until_refused`."""

    def __init__(self, campus_id: str, clock: Clock, bus: Bus, supervisor: Supervisor) -> None:
        self._clock, self._supervisor = clock, supervisor
        self._reader = TopicReader("access.read", bus, topics.access(campus_id), self._notify)
        self._changed = asyncio.Event()

    async def start(self) -> None:
        await self._reader.subscribe()
        self._supervisor.start(self._reader)

    async def until_refused(self, check: AccessCheck) -> DomainError:
        """Wait as long as the check passes: it is asked after each change, at the expiry and now and then."""
        while True:
            changed = self._changed
            try:
                expires_at = await check()
            except StoreFailure:
                # A database that does not answer ends no access.
                await asyncio.sleep(StoreFailure.retry_after_s)
                continue
            except DomainError as error:
                return error
            left_s = (expires_at - self._clock.now()).total_seconds()
            try:
                async with asyncio.timeout(max(0.0, min(left_s, RECHECK_EVERY_S))):
                    await changed.wait()
            except TimeoutError:
                continue

    def _notify(self, _topic: str, _payload: bytes) -> None:
        self._changed.set()
        self._changed = asyncio.Event()
