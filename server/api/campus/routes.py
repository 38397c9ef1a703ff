"""The active campus map: its facts, geometry and stops."""

from functools import lru_cache
from typing import Annotated

from fastapi import APIRouter, Header, Request, Response

from contract.roads.network import RoadNetwork
from server.api.campus.schemas import (
    CampusView,
    MapGeometry,
    StopView,
    campus_view,
    map_geometry,
    stop_view,
)
from server.api.content_coding import CodedBody, coded_body
from server.api.paging import ListLimit, Page, paged
from server.api.problems import problems
from server.api.services import InjectedServices
from server.domain.errors import CampusUnknown
from server.usecases.fleet import campus
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import calendars

# Of the campuses and versions that are asked for at a time.
MAPS_KEPT = 4

router = APIRouter(tags=["campus"])


@router.get("/campus", operation_id="get_campus", responses=problems(CampusUnknown))
async def get_campus(services: InjectedServices) -> CampusView:
    def work(uow: UnitOfWork) -> CampusView:
        today = calendars.service_day(uow)
        return campus_view(
            uow.campus_id,
            uow.network(),
            uow.rules,
            uow.now,
            calendars.calendar_of(uow),
            today,
            uow.vehicles.all(),
            has_timetable=bool(calendars.trips_of(uow)),
        )

    return await services.transactions.read(work)


@router.get("/stops", operation_id="list_stops", responses=paged(CampusUnknown))
async def list_stops(services: InjectedServices, page: Page, limit: ListLimit = None) -> list[StopView]:
    """Every stop of the active map, in map order."""
    numbered = enumerate(await services.transactions.read(campus.stops))
    return [stop_view(stop) for _, stop in page.cut(numbered, limit, lambda item: (item[0],))]


@router.get(
    "/campus/map",
    operation_id="get_campus_map",
    response_model=MapGeometry,
    responses=problems(CampusUnknown) | {304: {"description": "The map is the one in If-None-Match."}},
)
async def get_campus_map(
    services: InjectedServices,
    request: Request,
    if_none_match: Annotated[str | None, Header(max_length=200)] = None,
) -> Response:
    """Lanes, buildings and stops as compact arrays, with the map version as ETag."""

    def work(uow: UnitOfWork) -> tuple[str, CodedBody | None]:
        network = uow.network()
        etag = f'"{network.map_version}"'
        # Of the plain body or of a coded one: either means that the page has the map.
        is_known = if_none_match is not None and f'"{network.map_version}' in if_none_match
        return etag, None if is_known else _encoded_map(network)

    etag, encoded = await services.transactions.read(work)
    headers = {"Cache-Control": "no-cache"}
    if encoded is None:
        return Response(status_code=304, headers=headers | {"ETag": etag, "Vary": "Accept-Encoding"})
    accepted = request.headers.get("accept-encoding", "")
    return encoded.response(accepted, "application/json", etag, headers)


@lru_cache(maxsize=MAPS_KEPT)
def _encoded_map(network: RoadNetwork) -> CodedBody:
    """Made once for each map: it has some hundred kilobytes, and every page asks for it."""
    return coded_body(map_geometry(network, campus.stops_of(network)).model_dump_json().encode())
