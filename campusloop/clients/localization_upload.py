"""Sends a localization map to a running server: the manifest first, then the tiles that the server lacks."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import httpx

from contract.localization_manifest import decode_manifest
from contract.localization_maps import LocalizationMapError

API = "/api/v1/localization-maps"
INDEX = "index.json"


class UploadError(Exception):
    """The map is not stored, or not whole; the message is one sentence. A repeat goes on where it stopped."""


@dataclass(frozen=True, slots=True)
class UploadedMap:
    """sent: how many of its tiles the server lacked"""

    map_version: str
    kind: str
    tile_count: int
    size_bytes: int
    sent: int


def upload_localization_map(
    client: httpx.Client, folder: Path, note: str, progress: Callable[[int, int], None]
) -> UploadedMap:
    """Store the map of a folder; it is not put in force.

    client    with the server's base URL and a developer token of scope `drive`
    progress  is told how many tiles of how many missing ones are sent
    Raises UploadError, httpx.TransportError.
    """
    try:
        data = (folder / INDEX).read_bytes()
        manifest = decode_manifest(data)
    except OSError as error:
        raise UploadError(f"{folder} holds no localization map: {error.strerror or error}") from error
    except LocalizationMapError as error:
        raise UploadError(f"{folder} holds no map that can be published: {error}") from error
    headers = {"Content-Type": "application/json"}
    answer = client.post(API, content=data, headers=headers, params={"note": note})
    stored = _accepted(answer).json()
    files = {tile.sha256: tile.file for tile in manifest.tiles}
    missing = stored["missing"]
    for number, sha256 in enumerate(missing):
        progress(number, len(missing))
        try:
            content = (folder / files[sha256]).read_bytes()
        except OSError as error:
            raise UploadError(f"{folder / files[sha256]}: {error.strerror or error}") from error
        _accepted(client.put(f"{API}/{manifest.map_version}/tiles/{sha256}", content=content))
    progress(len(missing), len(missing))
    return UploadedMap(
        manifest.map_version, manifest.kind, len(manifest.tiles), manifest.size_bytes, len(missing)
    )


def _accepted(answer: httpx.Response) -> httpx.Response:
    if answer.is_success:
        return answer
    try:
        detail = answer.json()["detail"]
    except (ValueError, KeyError, TypeError):
        detail = answer.text[:300] or answer.reason_phrase
    raise UploadError(f"the server answers {answer.status_code}: {detail}")
