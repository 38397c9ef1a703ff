"""The link's part of a change of the localization map: fetch missing tiles, check, tell the tick."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import cast

import httpx
import structlog

from contract.localization_maps import LocalizationMapError, is_same_frame
from contract.roads.load import MapError
from contract.roads.model import Origin
from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.localization_maps import LocalizationMapFailure, LocalizationMapPublished
from contract.wire.messages import LocalizationMapFailed, LocalizationMapStored
from vehicle_agent.link.localization_download import LocalizationDownload, LocalizationMapNotTaken
from vehicle_agent.link.not_taken import NotTaken
from vehicle_agent.link.redial import Redial
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.maps.announced_change import AnnouncedChange
from vehicle_agent.stacks.choice import checked_localization_map

log = structlog.get_logger()

Report = Callable[[LocalizationMapStored | LocalizationMapFailed], Awaitable[None]]


class LocalizationChanger(AnnouncedChange[LocalizationMapPublished]):
    """Localization maps, tile by tile: what was fetched before a cut is not fetched again."""

    noun = "localization_map"

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
        """client: with the server's base URL. tell_tick: of the map that lies ready, "" for none.

        Which map the tick has it says by `taken`.
        """
        super().__init__(vehicle_id, "", tell_tick, redial)
        self._files = files
        self._client = client
        self._sign = sign
        self._report = report
        self._said_stored = ""

    async def _fetch(self, wanted: LocalizationMapPublished) -> None:
        maps = self._files.localization
        try:
            await asyncio.to_thread(maps.prune, wanted.map_version)
            if not await asyncio.to_thread(self._has_whole, wanted.map_version):
                await self._download(wanted)
        except OSError as error:
            # A broken disk must not end the link with it.
            raise LocalizationMapNotTaken("not_stored", str(error)) from error
        except MapError as error:
            raise LocalizationMapNotTaken("elsewhere", f"the road map cannot be read: {error}") from error
        if self._said_stored != wanted.map_version:
            self._said_stored = wanted.map_version
            await self._report(LocalizationMapStored(wanted.map_version))

    def _has_whole(self, map_version: str) -> bool:
        """It lies here since a change before, and no tile has been damaged since."""
        maps = self._files.localization
        if not maps.has(map_version):
            return False
        try:
            self._check(maps.root / map_version)
        except LocalizationMapError as error:
            log.error("localization_map.damaged", vehicle_id=self._vehicle_id, error=str(error))
            maps.give_up(maps.root / map_version)
            return False
        return True

    async def _download(self, wanted: LocalizationMapPublished) -> None:
        maps = self._files.localization
        download = LocalizationDownload(self._client, self._vehicle_id, self._sign, wanted)
        data, manifest = await download.manifest()
        await asyncio.to_thread(self._require_same_frame, manifest.origin)
        try:
            part, missing = await asyncio.to_thread(maps.begin, manifest, data)
        except OSError as error:
            raise LocalizationMapNotTaken("not_stored", str(error)) from error
        try:
            log.info(
                "localization_map.fetching",
                vehicle_id=self._vehicle_id,
                map_version=wanted.map_version,
                tiles=len(manifest.tiles),
                missing=len(missing),
            )
            for tile in missing:
                content = await download.tile(tile)
                await asyncio.to_thread(maps.save_tile, part, tile, content)
            await asyncio.to_thread(maps.seal, part)
            await asyncio.to_thread(self._check, part)
            await asyncio.to_thread(maps.complete, part, wanted.map_version)
        except OSError as error:
            await asyncio.to_thread(maps.give_up, part)
            raise LocalizationMapNotTaken("not_stored", str(error)) from error
        except LocalizationMapError as error:
            await asyncio.to_thread(maps.give_up, part)
            raise LocalizationMapNotTaken("unsound", str(error)) from error

    def _require_same_frame(self, origin: Origin) -> None:
        """Raises LocalizationMapNotTaken, MapError."""
        road_map = self._files.road_map()
        if not is_same_frame(origin, road_map.origin):
            raise LocalizationMapNotTaken(
                "elsewhere", f"it lies in another frame than road map {road_map.map_version}"
            )

    def _check(self, part: Path) -> None:
        """Every tile as the worker will read it. Takes a second or so. Raises LocalizationMapError."""
        checked_localization_map(self._files.profile(), part, self._files.road_map().origin)

    async def _tell_server(self, wanted: LocalizationMapPublished, failure: NotTaken) -> None:
        self._said_stored = ""
        detail = failure.detail[:LONG_CHARACTERS_MAX]
        # Only `LocalizationMapNotTaken` is raised here and by the tick.
        code = cast(LocalizationMapFailure, failure.code)
        await self._report(LocalizationMapFailed(wanted.map_version, code, detail))
