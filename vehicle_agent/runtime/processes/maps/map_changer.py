"""The link's part of a change of the road map: download, check, write to disk, and tell the tick."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import cast

import httpx

from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.maps import MapFailure, MapPublished
from contract.wire.messages import MapChangeFailed
from vehicle_agent.link.map_download import MapNotTaken, checked_map, download_map
from vehicle_agent.link.not_taken import NotTaken
from vehicle_agent.link.redial import Redial
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.maps.announced_change import AnnouncedChange

Report = Callable[[MapChangeFailed], Awaitable[None]]


class MapChanger(AnnouncedChange[MapPublished]):
    """Road maps."""

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
        road_map = files.road_map()
        super().__init__(vehicle_id, road_map.map_version, tell_tick, redial)
        self._files = files
        self._client = client
        self._sign = sign
        self._report = report
        self._campus_id = road_map.campus_id

    async def _fetch(self, wanted: MapPublished) -> None:
        data = await download_map(self._client, self._vehicle_id, self._sign, wanted)
        road_map = await asyncio.to_thread(checked_map, data, wanted, self._campus_id)
        try:
            await asyncio.to_thread(self._files.save_next_map, road_map.map_version, data)
        except OSError as error:
            raise MapNotTaken("not_stored", str(error)) from error

    async def _tell_server(self, wanted: MapPublished, failure: NotTaken) -> None:
        detail = failure.detail[:LONG_CHARACTERS_MAX]
        # Only `MapNotTaken` is raised here and by the tick.
        code = cast(MapFailure, failure.code)
        await self._report(MapChangeFailed(wanted.map_version, code, detail))
