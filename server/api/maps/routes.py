"""Versions of the campus map: listed, exported, put in force again."""

from typing import Annotated, Any

from fastapi import APIRouter, Path, Response

from server.api.commands import PublishCommand
from server.api.formats import NAME_PATTERN
from server.api.maps.schemas import MapVersionView, version_view
from server.api.paging import ListLimit, Page, microseconds_of, paged
from server.api.problems import problems
from server.api.security.access import (
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    SECOND_FACTOR_REFUSALS,
    Reader,
)
from server.api.services import InjectedServices
from server.domain.errors import MapInUse, MapUnknown
from server.domain.roads.maps import MapVersion, StoredMap
from server.usecases.fleet import campus, map_drafts
from server.usecases.ports.maps import ExportFormat
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/maps", tags=["maps"])

MapVersionId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["3f0c9a71d2e84b55"])]
MEDIA_TYPES = {"geojson": "application/geo+json", "lanelet2": "application/xml", "map": "application/json"}
ENDINGS = {"geojson": "geojson", "lanelet2": "osm", "map": "json"}
FILE: dict[int | str, dict[str, Any]] = {
    200: {"description": "The map as a file.", "content": {kind: {} for kind in MEDIA_TYPES.values()}}
}


@router.get("", operation_id="list_maps", responses=paged(*READER_REFUSALS))
async def list_maps(
    services: InjectedServices, _: Reader, page: Page, limit: ListLimit = None
) -> list[MapVersionView]:
    """Every stored version, the newest first."""
    found = await services.transactions.read(lambda uow: uow.maps.versions())
    return [version_view(version) for version in page.cut(found, limit, _newest_first)]


def _newest_first(version: MapVersion) -> tuple[int, str]:
    return -microseconds_of(version.added_at), version.map_version


@router.get(
    "/{map_version}/exports/{kind}",
    operation_id="export_map",
    response_class=Response,
    responses=problems(MapUnknown, *READER_REFUSALS) | FILE,
)
async def export_map(
    map_version: MapVersionId, kind: ExportFormat, services: InjectedServices, _: Reader
) -> Response:
    """GeoJSON, Lanelet2 or our own format; each can be imported again without loss."""
    road_map = await services.transactions.read(lambda uow: map_drafts.stored_map(uow, map_version))
    content = await services.offload.run(lambda: services.maps.exported(road_map, kind))
    return file_response(content, kind, map_version)


@router.post(
    "/{map_version}/activations",
    operation_id="activate_map",
    responses=problems(MapUnknown, MapInUse, *OPERATOR_REFUSALS, *SECOND_FACTOR_REFUSALS),
)
async def activate_map(map_version: MapVersionId, command: PublishCommand) -> MapVersionView:
    """Put a stored version in force: roll back, or forward again.

    No shuttle may be under way on what it changes.
    """

    def work(uow: UnitOfWork) -> MapVersionView:
        return stored_view(campus.activate_map(uow, map_version, command.by))

    return await command.transact(MapVersionView, work)


def stored_view(stored: StoredMap) -> MapVersionView:
    return version_view(MapVersion(stored.map_version, stored.name, stored.added_at, stored.active))


def file_response(content: bytes, kind: ExportFormat, name: str) -> Response:
    return Response(
        content,
        media_type=MEDIA_TYPES[kind],
        headers={"Content-Disposition": f'attachment; filename="{name}.{ENDINGS[kind]}"'},
    )
