"""What the link does for any kind of map that the server announces: fetch it, and tell the tick.

Whatever fails, the vehicle keeps the map that it has, the server is told why, and all is tried again.
"""

import asyncio
import random
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

import structlog

from vehicle_agent.link.not_taken import NotTaken
from vehicle_agent.link.redial import Redial

log = structlog.get_logger()

FIRST_RETRY_S, LONGEST_RETRY_S = 2.0, 60.0
# The tick ignores a repeat; one that was restarted meanwhile needs it.
TELL_EVERY_S = 5.0


class Published(Protocol):
    """What a server announces."""

    @property
    def map_version(self) -> str: ...


P = TypeVar("P", bound=Published)


class AnnouncedChange(ABC, Generic[P]):
    """`announced`, `refused` and `taken` take what the server and the tick say; `run` does the work."""

    # The noun of its log lines.
    noun = "map"

    def __init__(
        self, vehicle_id: str, present: str, tell_tick: Callable[[str], None], redial: Redial | None = None
    ) -> None:
        """present: the version that the tick uses. tell_tick: of the one that lies ready, "" for none."""
        self._vehicle_id = vehicle_id
        self._present = present
        self._tell_tick = tell_tick
        self._redial = redial or Redial(random.random, FIRST_RETRY_S, LONGEST_RETRY_S)
        self._wanted: P | None = None
        self._told: tuple[str, str] = ("", "")
        self._refusal: NotTaken | None = None
        self._changed = asyncio.Event()

    @abstractmethod
    async def _fetch(self, wanted: P) -> None:
        """Until it lies on the disk, whole and checked. Raises NotTaken."""

    @abstractmethod
    async def _tell_server(self, wanted: P, failure: NotTaken) -> None:
        """Why it is not taken; called once for each cause."""

    def announced(self, published: P) -> None:
        """The server names the map in force. A repeat changes nothing."""
        if self._wanted is not None and self._wanted.map_version == published.map_version:
            return
        if published.map_version == self._present:
            if self._wanted is None:
                return
            # Put back in force before the vehicle had the other one.
            self._tell_tick("")
            self._wanted = None
        else:
            log.info(f"{self.noun}.announced", vehicle_id=self._vehicle_id, map_version=published.map_version)
            self._wanted = published
        self._changed.set()

    def refused(self, map_version: str, refusal: NotTaken) -> None:
        """The tick cannot change over to it from where the vehicle stands."""
        if self._wanted is not None and self._wanted.map_version == map_version:
            self._refusal = refusal
            self._changed.set()

    def taken(self, map_version: str) -> None:
        """The tick uses it."""
        self._present = map_version
        if self._wanted is not None and self._wanted.map_version == map_version:
            self._wanted = None
        self._changed.set()

    async def run(self) -> None:
        """Runs until cancelled."""
        while True:
            if self._wanted is None:
                await self._until_changed(None)
                continue
            wanted = self._wanted
            try:
                await self._take(wanted)
            except NotTaken as failure:
                await self._failed(wanted, failure)
                await self._wait_to_retry(wanted)
            else:
                self._told = ("", "")
                self._redial.wait_s(was_welcomed=True, retry="later")

    async def _take(self, wanted: P) -> None:
        """Until the tick uses it, or another one is wanted. Raises NotTaken."""
        self._refusal = None  # of an attempt that was given up
        await self._fetch(wanted)
        log.info(f"{self.noun}.stored", vehicle_id=self._vehicle_id, map_version=wanted.map_version)
        while self._wanted is wanted:
            self._tell_tick(wanted.map_version)
            await self._until_changed(TELL_EVERY_S)
            self._raise_refusal()

    def _raise_refusal(self) -> None:
        if self._refusal is not None:
            refusal, self._refusal = self._refusal, None
            raise refusal

    async def _failed(self, wanted: P, failure: NotTaken) -> None:
        log.error(
            f"{self.noun}.not_taken",
            vehicle_id=self._vehicle_id,
            map_version=wanted.map_version,
            code=failure.code,
            detail=failure.detail,
        )
        # Once for each cause: it is tried again and again.
        told = (wanted.map_version, failure.code)
        if told != self._told:
            self._told = told
            await self._tell_server(wanted, failure)

    async def _wait_to_retry(self, wanted: P) -> None:
        """Longer after each failure; no longer than until another map is wanted."""
        loop = asyncio.get_running_loop()
        until_s = loop.time() + self._redial.wait_s(was_welcomed=False, retry="later")
        while self._wanted is wanted and loop.time() < until_s:
            await self._until_changed(until_s - loop.time())

    async def _until_changed(self, within_s: float | None) -> None:
        self._changed.clear()
        try:
            async with asyncio.timeout(within_s):
                await self._changed.wait()
        except TimeoutError:
            return
