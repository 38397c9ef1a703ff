"""The link's part of a change of the map: download, check, write to disk, and tell the tick.

Whatever fails, the vehicle keeps the map that it has, the server is told why, and all is tried again.
"""

import asyncio
import random
from collections.abc import Awaitable, Callable

import httpx
import structlog

from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.maps import MapPublished
from contract.wire.messages import MapChangeFailed
from vehicle_agent.link.map_download import MapNotTaken, checked_map, download_map
from vehicle_agent.link.redial import Redial
from vehicle_agent.runtime.processes.agent_files import AgentFolder

log = structlog.get_logger()

FIRST_RETRY_S, LONGEST_RETRY_S = 2.0, 60.0
# The tick ignores a repeat; one that was restarted meanwhile needs it.
TELL_EVERY_S = 5.0

Report = Callable[[MapChangeFailed], Awaitable[None]]


class MapChanger:
    """`announced` and `refused` take what the server and the tick say; `run` does the work."""

    def __init__(
        self,
        vehicle_id: str,
        files: AgentFolder,
        client: httpx.AsyncClient,
        sign: Callable[[bytes], str],
        report: Report,
        tell_tick: Callable[[str], None],
        redial: Redial | None = None,
    ) -> None:
        """client: with the server's base URL. tell_tick: of the map that lies ready, "" for none."""
        self._vehicle_id = vehicle_id
        self._files = files
        self._client = client
        self._sign = sign
        self._report = report
        self._tell_tick = tell_tick
        self._redial = redial or Redial(random.random, FIRST_RETRY_S, LONGEST_RETRY_S)
        self._wanted: MapPublished | None = None
        self._told: tuple[str, str] = ("", "")
        self._refusal: MapNotTaken | None = None
        self._changed = asyncio.Event()
        road_map = files.road_map()
        self._campus_id, self._present = road_map.campus_id, road_map.map_version

    def announced(self, published: MapPublished) -> None:
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
            log.info("map.announced", vehicle_id=self._vehicle_id, map_version=published.map_version)
            self._wanted = published
        self._changed.set()

    def refused(self, map_version: str, refusal: MapNotTaken) -> None:
        """The tick cannot drive by it from where the vehicle stands."""
        if self._wanted is not None and self._wanted.map_version == map_version:
            self._refusal = refusal
            self._changed.set()

    def taken(self, map_version: str) -> None:
        """The tick drives by it."""
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
            except MapNotTaken as failure:
                await self._failed(wanted, failure)
                await self._wait_to_retry(wanted)
            else:
                self._told = ("", "")
                self._redial.wait_s(was_welcomed=True, retry="later")

    async def _take(self, wanted: MapPublished) -> None:
        """Until the tick drives by it, or another one is wanted. Raises MapNotTaken."""
        self._refusal = None  # of an attempt that was given up
        data = await download_map(self._client, self._vehicle_id, self._sign, wanted)
        road_map = await asyncio.to_thread(checked_map, data, wanted, self._campus_id)
        try:
            await asyncio.to_thread(self._files.save_next_map, road_map.map_version, data)
        except OSError as error:
            raise MapNotTaken("not_stored", str(error)) from error
        log.info("map.stored", vehicle_id=self._vehicle_id, map_version=wanted.map_version)
        while self._wanted is wanted:
            self._tell_tick(wanted.map_version)
            await self._until_changed(TELL_EVERY_S)
            self._raise_refusal()

    def _raise_refusal(self) -> None:
        if self._refusal is not None:
            refusal, self._refusal = self._refusal, None
            raise refusal

    async def _failed(self, wanted: MapPublished, failure: MapNotTaken) -> None:
        log.error(
            "map.not_taken",
            vehicle_id=self._vehicle_id,
            map_version=wanted.map_version,
            code=failure.code,
            detail=failure.detail,
        )
        # Once for each cause: it is tried again and again.
        told = (wanted.map_version, failure.code)
        if told != self._told:
            self._told = told
            detail = failure.detail[:LONG_CHARACTERS_MAX]
            await self._report(MapChangeFailed(wanted.map_version, failure.code, detail))

    async def _wait_to_retry(self, wanted: MapPublished) -> None:
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
