"""Downloads the manifest and the tiles of a published localization map, each checked by its hash."""

import hashlib
from collections.abc import Callable

import httpx

from contract.localization_manifest import LocalizationManifest, TileFile, decode_manifest
from contract.localization_maps import LocalizationMapError
from contract.wire.localization_maps import (
    LocalizationMapFailure,
    LocalizationMapPublished,
    localization_manifest_path,
    localization_tile_path,
    signed_localization_request,
)
from contract.wire.upload import SIGNATURE_HEADER
from vehicle_agent.link.not_taken import NotTaken

# Between two parts of an answer: a server that dies in the middle is noticed.
TIMEOUT_S = 20.0


class LocalizationMapNotTaken(NotTaken):
    """The vehicle keeps the localization map that it has."""

    def __init__(self, code: LocalizationMapFailure, detail: str) -> None:
        super().__init__(code, detail)


class LocalizationDownload:
    """The files of one published map, from one server."""

    def __init__(
        self,
        client: httpx.AsyncClient,
        vehicle_id: str,
        sign: Callable[[bytes], str],
        published: LocalizationMapPublished,
    ) -> None:
        """client: with the server's base URL; sign: base64 of the vehicle key's signature"""
        self._client = client
        self._published = published
        text = signed_localization_request(vehicle_id, published.map_version)
        self._headers = {SIGNATURE_HEADER: sign(text), "Vehicle-Id": vehicle_id, "Accept-Encoding": "gzip"}

    async def manifest(self) -> tuple[bytes, LocalizationManifest]:
        """The announced bytes, and what they say. Raises LocalizationMapNotTaken."""
        told = self._published
        data = await self._get(
            localization_manifest_path(told.map_version), told.size_bytes, told.sha256, "the manifest"
        )
        try:
            manifest = decode_manifest(data)
        except LocalizationMapError as error:
            raise LocalizationMapNotTaken("unsound", str(error)) from error
        if (manifest.map_version, manifest.kind) != (told.map_version, told.kind):
            raise LocalizationMapNotTaken(
                "unsound", f"it is {manifest.kind} {manifest.map_version}, not {told.kind} {told.map_version}"
            )
        return data, manifest

    async def tile(self, tile: TileFile) -> bytes:
        """The bytes that the manifest names. Raises LocalizationMapNotTaken."""
        path = localization_tile_path(self._published.map_version, tile.sha256)
        return await self._get(path, tile.bytes, tile.sha256, tile.file)

    async def _get(self, path: str, size_bytes: int, sha256: str, what: str) -> bytes:
        """Reads no more than was announced."""
        data = bytearray()
        try:
            async with self._client.stream("GET", path, headers=self._headers, timeout=TIMEOUT_S) as response:
                if response.status_code != 200:
                    answer = (await response.aread())[:300].decode(errors="replace")
                    raise LocalizationMapNotTaken(
                        "not_downloaded", f"{what}: the server answers {response.status_code}: {answer}"
                    )
                async for part in response.aiter_bytes():
                    data += part
                    if len(data) > size_bytes:
                        raise LocalizationMapNotTaken("damaged", f"{what} has more than {size_bytes} bytes")
        except httpx.DecodingError as error:
            raise LocalizationMapNotTaken("damaged", f"{what} cannot be decompressed: {error}") from error
        except httpx.TransportError as error:
            cause = str(error) or type(error).__name__
            raise LocalizationMapNotTaken(
                "not_downloaded", f"{what} broke off after {len(data)} bytes: {cause}"
            ) from error
        found = hashlib.sha256(data).hexdigest()
        if found != sha256:
            raise LocalizationMapNotTaken(
                "damaged", f"{what} has SHA-256 {found}, and {sha256} was announced"
            )
        return bytes(data)
