"""Uploads finished run segments to the server, by content hash: a repeat is harmless."""

import asyncio
from collections.abc import Callable, Mapping
from pathlib import Path

import httpx
import structlog

from contract.wire.upload import SIGNATURE_HEADER, segment_path, signed_segment

log = structlog.get_logger()

RETRY_AFTER_S = 20.0
TIMEOUT_S = 120.0


async def put_segment(
    client: httpx.AsyncClient, vehicle_id: str, sign: Callable[[bytes], str], data: bytes, sha256: str
) -> httpx.Response:
    """Uploads one signed segment. Raises httpx.TransportError."""
    signature = sign(signed_segment(vehicle_id, sha256))
    return await put_signed(client, segment_path(sha256), vehicle_id, signature, data)


async def put_signed(
    client: httpx.AsyncClient,
    path: str,
    vehicle_id: str,
    signature: str,
    data: bytes,
    headers: Mapping[str, str] | None = None,
) -> httpx.Response:
    """One PUT of a vehicle's bytes with its signature. Raises httpx.TransportError."""
    signed = {SIGNATURE_HEADER: signature, "Vehicle-Id": vehicle_id, **(headers or {})}
    return await client.put(path, content=data, headers=signed, timeout=TIMEOUT_S)


class SegmentUploader:
    """Uploads one vehicle's segments, and retries."""

    def __init__(self, vehicle_id: str, client: httpx.AsyncClient, sign: Callable[[bytes], str]) -> None:
        """client  with the server's base URL; sign: base64 of the vehicle key's signature."""
        self._vehicle_id = vehicle_id
        self._client = client
        self._sign = sign
        self._waiting: asyncio.Queue[tuple[Path, str]] = asyncio.Queue()

    def add(self, path: Path, sha256: str) -> None:
        self._waiting.put_nowait((path, sha256))

    async def run(self) -> None:
        """Until cancelled."""
        while True:
            path, sha256 = await self._waiting.get()
            if not await self.upload(path, sha256):
                self._waiting.put_nowait((path, sha256))
                await asyncio.sleep(RETRY_AFTER_S)

    async def upload(self, path: Path, sha256: str) -> bool:
        """One attempt. True if nothing is left to do: stored, known already, or refused."""
        data = await asyncio.to_thread(path.read_bytes)
        try:
            response = await put_segment(self._client, self._vehicle_id, self._sign, data, sha256)
        except httpx.TransportError as error:
            log.warning("run.upload_failed", vehicle_id=self._vehicle_id, path=str(path), error=str(error))
            return False
        if response.status_code >= 500 or response.status_code in (408, 429):
            log.warning(
                "run.upload_failed", vehicle_id=self._vehicle_id, path=str(path), status=response.status_code
            )
            return False
        if response.is_error:
            log.error(
                "run.upload_refused", vehicle_id=self._vehicle_id, path=str(path), answer=response.text[:300]
            )
        else:
            log.info("run.uploaded", vehicle_id=self._vehicle_id, sha256=sha256, size_bytes=len(data))
        return True
