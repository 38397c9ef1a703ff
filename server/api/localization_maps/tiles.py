"""Tiles of localization maps, by the hash of their bytes: sent once, read by all who may read maps."""

from functools import lru_cache
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request, Response

from contract.localization_manifest import TILE_BYTES_MAX, tile_check
from contract.localization_maps import LocalizationMapError
from server.api.formats import Sha256
from server.api.localization_maps.routes import FOR_EVER, LocalizationMapId, is_known
from server.api.problems import TileHashWrong, TileStoreUnavailable, problems
from server.api.security.access import DRIVER_REFUSALS, READER_REFUSALS, Actor, Reader, changing
from server.api.security.permissions import STORE_LOCALIZATION_MAPS
from server.api.services import InjectedServices, Services
from server.domain.errors import (
    LocalizationMapUnknown,
    LocalizationTileInvalid,
    LocalizationTileUnknown,
)
from server.store.segments.incoming import IncomingSegment, SegmentHashError, SegmentSizeError
from server.store.segments.segment_store import SegmentStoreError
from server.usecases.fleet import localization_maps
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/localization-maps", tags=["localization maps"])

MEDIA_TYPE = "application/octet-stream"
TILE: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "The tile as it was published; zstd-compressed by itself.",
        "content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
    },
    304: {"description": "The client has it."},
}


@router.put(
    "/{map_version}/tiles/{sha256}",
    operation_id="put_localization_tile",
    status_code=204,
    max_body_size=TILE_BYTES_MAX,
    responses=problems(
        LocalizationMapUnknown,
        LocalizationTileUnknown,
        LocalizationTileInvalid,
        TileHashWrong,
        TileStoreUnavailable,
        *DRIVER_REFUSALS,
    ),
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def put_localization_tile(
    map_version: LocalizationMapId,
    sha256: Sha256,
    request: Request,
    services: InjectedServices,
    _: Annotated[Actor, Depends(changing(STORE_LOCALIZATION_MAPS))],
) -> None:
    """A tile that the stored manifest names, by the SHA-256 of its bytes. A repeat is harmless.

    The tile is decoded: one that vehicles could not read is refused.
    """

    def named(uow: UnitOfWork) -> tuple[bytes, bool]:
        localization_maps.require_named(uow, map_version, sha256)
        return localization_maps.manifest_of(uow, map_version), uow.localization_maps.is_kept(sha256)

    manifest, is_entered = await services.transactions.read(named)
    if is_entered and await _has(services, sha256):
        return
    try:
        with services.tiles.receive(sha256, services.ids.new_id("tile")) as incoming:
            await _receive(services, request, incoming, manifest)
    except OSError as error:
        raise TileStoreUnavailable(f"the tile cannot be kept now ({error}); send it again") from error
    tiles = frozenset((sha256,))
    await services.transactions.run(lambda uow: localization_maps.keep_tiles(uow, map_version, tiles))


@router.get(
    "/{map_version}/tiles/{sha256}",
    operation_id="get_localization_tile",
    response_class=Response,
    responses=problems(
        LocalizationMapUnknown, LocalizationTileUnknown, TileStoreUnavailable, *READER_REFUSALS
    )
    | TILE,
)
async def get_localization_tile(
    map_version: LocalizationMapId, sha256: Sha256, request: Request, services: InjectedServices, _: Reader
) -> Response:
    """Never changes: it may be kept for ever."""
    return await tile_response(services, request, map_version, sha256)


async def tile_response(services: Services, request: Request, map_version: str, sha256: str) -> Response:
    """Raises LocalizationMapUnknown, LocalizationTileUnknown, TileStoreUnavailable."""
    await services.transactions.read(lambda uow: localization_maps.require_named(uow, map_version, sha256))
    headers = {"ETag": f'"{sha256}"', **FOR_EVER}
    if is_known(request, sha256):
        return Response(status_code=304, headers=headers)
    data = await _fetched(services, sha256)
    if data is None:
        raise LocalizationTileUnknown(f"the bytes of tile {sha256} have not come yet")
    return Response(data, media_type=MEDIA_TYPE, headers=headers)


async def _receive(services: Services, request: Request, incoming: IncomingSegment, manifest: bytes) -> None:
    """Raises TileHashWrong, LocalizationTileInvalid, TileStoreUnavailable, OSError."""
    try:
        async for chunk in request.stream():
            incoming.write(chunk)
        path = await services.offload.run(incoming.prove)
    except (SegmentHashError, SegmentSizeError) as error:
        raise TileHashWrong(f"{error}; send the tile again") from error
    sha256 = incoming.sha256
    try:
        await services.offload.run(lambda: _check(manifest)(sha256, path.read_bytes()))
    except LocalizationMapError as error:
        raise LocalizationTileInvalid(str(error).rstrip(".")) from error
    try:
        await services.offload.run(lambda: services.tiles.keep(incoming))
    except SegmentStoreError as error:
        raise TileStoreUnavailable(f"{error}; send the tile again") from error


# One for each map that is being sent.
_check = lru_cache(maxsize=4)(tile_check)


async def _has(services: Services, sha256: str) -> bool:
    try:
        return await services.offload.run(lambda: services.tiles.has(sha256))
    except SegmentStoreError as error:
        raise TileStoreUnavailable(f"{error}; send the tile again") from error


async def _fetched(services: Services, sha256: str) -> bytes | None:
    def read() -> bytes | None:
        path = services.tiles.fetch(sha256)
        return None if path is None else path.read_bytes()

    try:
        return await services.offload.run(read)
    except (SegmentStoreError, OSError) as error:
        raise TileStoreUnavailable(str(error)) from error
