"""The link's part of video: marks to the recording process, what that process lays out to the server."""

import asyncio
import hashlib
from collections.abc import Callable
from pathlib import Path

import httpx
import structlog

from contract.video import SEGMENT_HEADER, name_of, signed_video, video_path
from vehicle_agent.link.upload import put_signed

log = structlog.get_logger()

LOOK_S, RETRY_AFTER_S = 2.0, 20.0
REFUSED_MAX = 20
_REFUSED = ".refused"


class VideoUploads:
    """Uploads the files of a folder, oldest first, and deletes what the server has."""

    def __init__(
        self,
        vehicle_id: str,
        folder: Path,
        client: httpx.AsyncClient,
        sign: Callable[[bytes], str],
        retry_after_s: float = RETRY_AFTER_S,
    ) -> None:
        """folder: of what may leave the vehicle. client: with the server's base URL."""
        self._vehicle_id, self._folder = vehicle_id, folder
        self._client, self._sign, self._retry_after_s = client, sign, retry_after_s

    async def run(self) -> None:
        """Runs until cancelled."""
        while True:
            try:
                is_well = await self.upload_waiting()
            except OSError as error:
                is_well = False
                log.error("video.folder_broken", vehicle_id=self._vehicle_id, error=str(error))
            await asyncio.sleep(LOOK_S if is_well else self._retry_after_s)

    async def upload_waiting(self) -> bool:
        """False if the server cannot take them now. Raises OSError."""
        for path in await asyncio.to_thread(self._waiting):
            if not await self._upload(path):
                return False
        return True

    def _waiting(self) -> list[Path]:
        """By their time."""
        names = [name for path in self._folder.glob("*.webm") if (name := name_of(path.name)) is not None]
        return [
            self._folder / name.text() for name in sorted(names, key=lambda one: (one.utc_ns, one.camera))
        ]

    async def _upload(self, path: Path) -> bool:
        """One attempt; False if the server cannot take it now."""
        data, sha256 = await asyncio.to_thread(_read, path)
        signature = self._sign(signed_video(self._vehicle_id, sha256, path.name))
        try:
            response = await put_signed(
                self._client,
                video_path(sha256),
                self._vehicle_id,
                signature,
                data,
                {SEGMENT_HEADER: path.name},
            )
        except httpx.TransportError as error:
            log.warning("video.not_uploaded", vehicle_id=self._vehicle_id, error=str(error))
            return False
        if response.status_code >= 500 or response.status_code in (408, 429):
            log.warning("video.not_uploaded", vehicle_id=self._vehicle_id, status=response.status_code)
            return False
        if response.is_error:
            log.error("video.refused", vehicle_id=self._vehicle_id, answer=response.text[:300])
            await asyncio.to_thread(_put_aside, path)
            return True
        log.info("video.uploaded", vehicle_id=self._vehicle_id, file=path.name, size_bytes=len(data))
        await asyncio.to_thread(path.unlink, True)
        return True


def _put_aside(path: Path) -> None:
    """Keep a refused copy, so that people can look into it, and delete the oldest ones. Raises OSError."""
    path.rename(path.with_suffix(_REFUSED))
    refused = sorted(path.parent.glob(f"*{_REFUSED}"), key=lambda one: one.stat().st_mtime_ns)
    for old in refused[:-REFUSED_MAX]:
        old.unlink()


def _read(path: Path) -> tuple[bytes, str]:
    """A file and the SHA-256 of its bytes."""
    data = path.read_bytes()
    return data, hashlib.sha256(data).hexdigest()
