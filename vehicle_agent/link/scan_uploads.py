"""The link's part of keeping scans: requests and track to the keeping process, parcels to the server."""

import asyncio
import hashlib
from collections.abc import Awaitable, Callable
from pathlib import Path

import httpx
import structlog

from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.messages import ScanArea, ScansReported, ScansRequested
from contract.wire.scans import ScanState, parcel_path, signed_parcel
from vehicle_agent.link.upload import put_signed

log = structlog.get_logger()

LOOK_S, RETRY_AFTER_S = 1.0, 20.0
# The keeping process reports once a second.
SILENT_S = 10.0
_REFUSED = ".refused"

Report = Callable[[ScansReported], Awaitable[None]]


class ScanUploads:
    """`requested` and `kept` take what the server and the keeping process say; `run` uploads and reports."""

    def __init__(
        self,
        vehicle_id: str,
        folder: Path,
        client: httpx.AsyncClient,
        sign: Callable[[bytes], str],
        report: Report,
        tell_keeper: Callable[[tuple[ScanArea, ...]], None],
        retry_after_s: float = RETRY_AFTER_S,
    ) -> None:
        """folder: of the parcels, one folder in it for each request. client: with the server's base URL."""
        self._vehicle_id, self._folder = vehicle_id, folder
        self._client, self._sign = client, sign
        self._report, self._tell_keeper = report, tell_keeper
        self._retry_after_s = retry_after_s
        self.areas: tuple[ScanArea, ...] = ()
        self._said: dict[str, ScansReported] = {}
        self._newest: dict[str, ScansReported] = {}
        self._trouble: dict[str, str] = {}
        self._heard_s = 0.0

    def requested(self, message: ScansRequested) -> None:
        """All open requests; the former ones that are missing have ended."""
        for area in self.areas:
            if area.request_id not in {one.request_id for one in message.areas}:
                log.info("scans.request_over", vehicle_id=self._vehicle_id, request_id=area.request_id)
        self.areas = message.areas
        self._heard_s = asyncio.get_running_loop().time()
        self._tell_keeper(self.areas)

    def kept(self, reports: tuple[ScansReported, ...]) -> None:
        """From the keeping process."""
        self._heard_s = asyncio.get_running_loop().time()
        for report in reports:
            self._newest[report.request_id] = report

    async def run(self) -> None:
        """Runs until cancelled."""
        while True:
            if self.areas:
                # The process may have been restarted.
                self._tell_keeper(self.areas)
            try:
                is_well = await self._upload_waiting()
            except OSError as error:
                # A broken disk ends neither the link nor, once it is well, the uploads.
                is_well = False
                log.error("scans.folder_broken", vehicle_id=self._vehicle_id, error=str(error))
            await asyncio.sleep(LOOK_S if is_well else self._retry_after_s)

    async def _upload_waiting(self) -> bool:
        """False if the server cannot take them now. Raises OSError."""
        waiting = await asyncio.to_thread(self._waiting)
        is_well = True
        for path in waiting:
            is_well = await self._upload(path)
            await self._tell_server(waiting)
            if not is_well:
                break
        await self._tell_server([path for path in waiting if path.exists()])
        return is_well

    def _waiting(self) -> list[Path]:
        """Parcels, oldest first."""
        return sorted(self._folder.glob("*/*.zip"), key=lambda path: path.stat().st_mtime_ns)

    async def _upload(self, path: Path) -> bool:
        """One attempt; False if the server cannot take it now."""
        request_id = path.parent.name
        try:
            data = await asyncio.to_thread(path.read_bytes)
        except OSError as error:
            # The others go up all the same.
            self._note_trouble(request_id, f"a parcel cannot be read: {error}")
            return True
        sha256 = hashlib.sha256(data).hexdigest()
        signature = self._sign(signed_parcel(self._vehicle_id, sha256))
        try:
            response = await put_signed(self._client, parcel_path(sha256), self._vehicle_id, signature, data)
        except httpx.TransportError as error:
            self._note_trouble(
                request_id, f"the server cannot be reached: {str(error) or type(error).__name__}"
            )
            return False
        if response.status_code >= 500 or response.status_code in (408, 429):
            self._note_trouble(
                request_id, f"the server answers {response.status_code}: {response.text[:300]}"
            )
            return False
        if response.is_error:
            # Kept beside the others, so that people can look into it; it counts among what may be kept.
            self._note_trouble(request_id, f"refused: {response.text[:300]}")
            await asyncio.to_thread(path.rename, path.with_suffix(_REFUSED))
            return True
        log.info("scans.uploaded", vehicle_id=self._vehicle_id, sha256=sha256, size_bytes=len(data))
        self._trouble.pop(request_id, None)
        await asyncio.to_thread(path.unlink, True)
        return True

    def _note_trouble(self, request_id: str, detail: str) -> None:
        if self._trouble.get(request_id) != detail:
            log.warning(
                "scans.not_uploaded", vehicle_id=self._vehicle_id, request_id=request_id, error=detail
            )
        self._trouble[request_id] = detail

    async def _tell_server(self, waiting: list[Path]) -> None:
        """What has changed of each request: state, reason, or how much is kept."""
        names = {area.request_id for area in self.areas}
        is_silent = asyncio.get_running_loop().time() - self._heard_s > SILENT_S
        for request_id in sorted(names | self._said.keys()):
            report = self._newest.get(request_id) or ScansReported(request_id, "waiting", 0, 0.0, 0)
            left = sum(path.parent.name == request_id for path in waiting)
            state, detail = report.state, report.detail
            is_over = request_id not in names
            if is_over and state != "ended" and not is_silent:
                # The process has not said yet how much it kept in the end.
                continue
            if is_over:
                state = "ended"
            trouble = self._trouble.get(request_id)
            if trouble is not None and (left or not is_over):
                state, detail = "not_uploaded", trouble
            elif trouble is not None:
                detail = trouble
            elif is_silent and not is_over:
                state, detail = "keeper_silent", f"not heard for {SILENT_S:.0f} s"
            elif state == "ended" and left:
                state, detail = "collecting", f"{left} parcels wait for their upload"
            await self._say(report, state, detail)
            if is_over and state == "ended":
                self._said.pop(request_id)
                self._newest.pop(request_id, None)
                self._trouble.pop(request_id, None)
                await asyncio.to_thread(self._forget, request_id)

    def _forget(self, request_id: str) -> None:
        """What the server has refused of a request that is over."""
        for path in (self._folder / request_id).glob(f"*{_REFUSED}"):
            path.unlink(missing_ok=True)

    async def _say(self, report: ScansReported, state: ScanState, detail: str) -> None:
        said = ScansReported(
            report.request_id,
            state,
            report.scans,
            round(report.way_m, 1),
            report.bytes_kept,
            detail[:LONG_CHARACTERS_MAX],
        )
        before = self._said.get(report.request_id)
        if before is None or _key(before) != _key(said):
            self._said[report.request_id] = said
            await self._report(said)


def _key(report: ScansReported) -> tuple[str, str, int]:
    """What is worth an event: every scan is not."""
    return report.state, report.detail, report.bytes_kept
