"""The active campus map: its facts, geometry and stops."""

import hashlib
from functools import lru_cache
from typing import Annotated

from fastapi import APIRouter, Header, Request, Response
from pydantic import TypeAdapter

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
from server.domain.roads.stops import CampusStop
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


@router.get(
    "/stops", operation_id="list_stops", response_model=list[StopView], responses=paged(CampusUnknown)
)
async def list_stops(
    services: InjectedServices, request: Request, response: Response, page: Page, limit: ListLimit = None
) -> Response:
    """Every stop of the active map, in map order."""
    numbered = enumerate(await services.transactions.read(campus.stops))
    found = tuple(stop for _, stop in page.cut(numbered, limit, lambda item: (item[0],)))
    etag, encoded = _encoded_stops(found)
    links = {name: value for name, value in response.headers.items() if name == "link"}
    accepted = request.headers.get("accept-encoding", "")
    return encoded.response(accepted, "application/json", etag, {"Cache-Control": "no-cache"} | links)


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
def _encoded_stops(stops: tuple[CampusStop, ...]) -> tuple[str, CodedBody]:
    """(entity tag, body): every phone waits for it, at a third of the size."""
    body = TypeAdapter(list[StopView]).dump_json([stop_view(stop) for stop in stops])
    return f'"{hashlib.sha256(body).hexdigest()[:32]}"', coded_body(body)


@lru_cache(maxsize=MAPS_KEPT)
def _encoded_map(network: RoadNetwork) -> CodedBody:
    """Made once for each map: it has some hundred kilobytes, and every page asks for it."""
    return coded_body(map_geometry(network, campus.stops_of(network)).model_dump_json().encode())
