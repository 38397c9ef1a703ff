"""Localization maps: listed, stored by their manifest, put in force, removed."""

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Request, Response

from contract.localization_manifest import MANIFEST_BYTES_MAX
from contract.roads.model import Origin
from server.api.commands import PublishCommand, StoreLocalizationMapCommand
from server.api.content_coding import coded_body
from server.api.formats import SHA256_PATTERN, FreeText
from server.api.localization_maps.schemas import (
    VERSION_EXAMPLE,
    LocalizationMapDetails,
    LocalizationMapView,
    details_view,
    map_view,
)
from server.api.paging import ListLimit, Page, microseconds_of, paged
from server.api.problems import TileStoreUnavailable, problems
from server.api.security.access import (
    DRIVER_REFUSALS,
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    SECOND_FACTOR_REFUSALS,
    Reader,
)
from server.api.services import InjectedServices, Services
from server.domain.errors import (
    CampusUnknown,
    LocalizationMapElsewhere,
    LocalizationMapIncomplete,
    LocalizationMapInForce,
    LocalizationMapInvalid,
    LocalizationMapUnknown,
    TooManyLocalizationMaps,
)
from server.domain.roads.localization_maps import LocalizationMap
from server.store.segments.segment_store import SegmentStoreError
from server.usecases.fleet import localization_maps
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/localization-maps", tags=["localization maps"])

LocalizationMapId = Annotated[str, Path(pattern=SHA256_PATTERN, examples=[VERSION_EXAMPLE])]
Note = Annotated[FreeText, Query(description="What it was made of, for operators.", examples=["survey"])]
# A version never changes, so that it may be kept for ever; by the one who asked alone.
FOR_EVER = {"Cache-Control": "private, max-age=31536000, immutable"}
MANIFEST: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "The index of the map's folder: kind, version, frame, and each tile's place, size and "
        "SHA-256.",
        "content": {"application/json": {"schema": {"type": "object", "additionalProperties": True}}},
    },
    304: {"description": "The client has it."},
}


@router.get("", operation_id="list_localization_maps", responses=paged(*READER_REFUSALS))
async def list_localization_maps(
    services: InjectedServices, _: Reader, page: Page, limit: ListLimit = None
) -> list[LocalizationMapView]:
    """Every stored version, the newest first."""
    found, vehicles, origin = await services.transactions.read(
        lambda uow: (uow.localization_maps.all(), uow.vehicles.all(), _origin(uow))
    )
    return [map_view(stored, vehicles, origin) for stored in page.cut(found, limit, _newest_first)]


def _newest_first(stored: LocalizationMap) -> tuple[int, str]:
    return -microseconds_of(stored.published_at), stored.map_version


@router.post(
    "",
    operation_id="store_localization_map",
    status_code=201,
    max_body_size=MANIFEST_BYTES_MAX,
    responses=problems(
        LocalizationMapInvalid,
        LocalizationMapElsewhere,
        TooManyLocalizationMaps,
        CampusUnknown,
        *DRIVER_REFUSALS,
    ),
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/json": {"schema": {"type": "object", "additionalProperties": True}}},
        }
    },
)
async def store_localization_map(
    request: Request, services: InjectedServices, command: StoreLocalizationMapCommand, note: Note = ""
) -> LocalizationMapDetails:
    """Store a version by its manifest, the `index.json` of its folder. Then send the `missing` tiles.

    It is not in force yet. A repeat changes nothing, and answers what is still missing.
    """
    data = await request.body()
    manifest = await services.offload.run(lambda: localization_maps.decoded(data))

    def work(uow: UnitOfWork) -> LocalizationMapDetails:
        return _details(uow, localization_maps.store_manifest(uow, data, manifest, command.by, note))

    return await command.about(manifest.map_version, note).transact(LocalizationMapDetails, work)


@router.get(
    "/{map_version}",
    operation_id="get_localization_map",
    responses=problems(LocalizationMapUnknown, *READER_REFUSALS),
)
async def get_localization_map(
    map_version: LocalizationMapId, services: InjectedServices, _: Reader
) -> LocalizationMapDetails:
    """One version, and which of its tiles are missing."""
    return await services.transactions.read(
        lambda uow: _details(uow, localization_maps.localization_map_of(uow, map_version))
    )


@router.get(
    "/{map_version}/manifest",
    operation_id="get_localization_manifest",
    response_class=Response,
    responses=problems(LocalizationMapUnknown, *READER_REFUSALS) | MANIFEST,
)
async def get_localization_manifest(
    map_version: LocalizationMapId, request: Request, services: InjectedServices, _: Reader
) -> Response:
    return await manifest_response(services, request, map_version)


@router.post(
    "/{map_version}/activations",
    operation_id="activate_localization_map",
    responses=problems(
        LocalizationMapUnknown,
        LocalizationMapIncomplete,
        LocalizationMapElsewhere,
        CampusUnknown,
        *OPERATOR_REFUSALS,
        *SECOND_FACTOR_REFUSALS,
    ),
)
async def activate_localization_map(
    map_version: LocalizationMapId, command: PublishCommand
) -> LocalizationMapView:
    """Put a stored version in force, or roll back to one.

    Vehicles that localize by maps of its kind fetch it, and change over while they stand.
    """

    def work(uow: UnitOfWork) -> LocalizationMapView:
        stored = localization_maps.activate(uow, map_version, command.by)
        return map_view(stored, uow.vehicles.all(), _origin(uow))

    return await command.transact(LocalizationMapView, work)


@router.delete(
    "/{map_version}",
    operation_id="remove_localization_map",
    status_code=204,
    responses=problems(
        LocalizationMapUnknown,
        LocalizationMapInForce,
        TileStoreUnavailable,
        *OPERATOR_REFUSALS,
        *SECOND_FACTOR_REFUSALS,
    ),
)
async def remove_localization_map(
    map_version: LocalizationMapId, services: InjectedServices, command: PublishCommand
) -> None:
    """Remove a version that is not in force, with the tiles that no other version has."""
    unneeded = await command.transact(
        list[str], lambda uow: sorted(localization_maps.remove(uow, map_version, command.by))
    )

    def delete() -> None:
        for sha256 in unneeded:
            services.tiles.remove(sha256)

    try:
        await services.offload.run(delete)
    except (SegmentStoreError, OSError) as error:
        raise TileStoreUnavailable(f"the map is removed, but tiles of it are left: {error}") from error


async def manifest_response(services: Services, request: Request, map_version: str) -> Response:
    """Raises LocalizationMapUnknown."""
    etag = f'"{map_version}"'
    data = await services.transactions.read(lambda uow: localization_maps.manifest_of(uow, map_version))
    if is_known(request, map_version):
        return Response(status_code=304, headers={"ETag": etag, **FOR_EVER})
    body = await services.offload.run(lambda: coded_body(data))
    accepted = request.headers.get("Accept-Encoding", "")
    return body.response(accepted, "application/json", etag, FOR_EVER)


def is_known(request: Request, tag: str) -> bool:
    """The client has this version, in whatever coding (RFC 9110, 13.1.2)."""
    known = request.headers.get("If-None-Match", "")
    return (
        any(one.strip().removeprefix("W/").startswith(f'"{tag}') for one in known.split(",")) or known == "*"
    )


def _details(uow: UnitOfWork, stored: LocalizationMap) -> LocalizationMapDetails:
    missing = localization_maps.missing_tiles(uow, stored.map_version)
    return details_view(stored, uow.vehicles.all(), _origin(uow), missing)


def _origin(uow: UnitOfWork) -> Origin | None:
    """Of the road map in force."""
    return None if uow.maps.active_version() is None else uow.network().road_map.origin
