"""Requests for lidar scans of an area: listed, begun, ended by operators."""

from typing import Annotated, Literal

from fastapi import APIRouter, Path, Query

from server.api.commands import DrawCommand
from server.api.formats import NAME_PATTERN
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import problems
from server.api.scans.schemas import NewScanRequest, ScanRequestView, request_view
from server.api.security.access import OPERATOR_REFUSALS, READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.domain.errors import (
    CampusUnknown,
    ScanAreaInvalid,
    ScanAreaTaken,
    ScanRequestOver,
    ScanRequestUnknown,
)
from server.domain.fleet.scans import ScanRequest
from server.usecases.fleet import scans
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/scan-requests", tags=["scans"])

ScanRequestId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["scans-4"])]


@router.get("", operation_id="list_scan_requests", responses=paged(*READER_REFUSALS))
async def list_scan_requests(
    services: InjectedServices, _: Reader, page: Page, limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 50
) -> list[ScanRequestView]:
    """Newest first, each with what came from which vehicle."""
    ended = page.after(int, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]))

    def work(uow: UnitOfWork) -> list[ScanRequestView]:
        return [_view(uow, one) for one in uow.scans.newest_requests(limit + 1, after)]

    found = await services.transactions.read(work)
    return page.first(found, limit, lambda one: (microseconds_of(one.started_at), one.request_id))


@router.post(
    "",
    operation_id="request_scans",
    status_code=201,
    responses=problems(CampusUnknown, ScanAreaInvalid, ScanAreaTaken, *OPERATOR_REFUSALS),
)
async def request_scans(body: NewScanRequest, command: DrawCommand) -> ScanRequestView:
    """All vehicles with a lidar keep scans inside this area while they drive there, and send them."""

    def work(uow: UnitOfWork) -> ScanRequestView:
        outline = tuple(body.outline)
        asked = scans.request_scans(
            uow, body.name, outline, body.every_m, body.bytes_max, body.hours, command.by
        )
        return _view(uow, asked)

    return await command.about(body.name).transact(ScanRequestView, work)


@router.post(
    "/{request_id}/end",
    operation_id="end_scan_request",
    responses=problems(ScanRequestUnknown, ScanRequestOver, *OPERATOR_REFUSALS),
)
async def end_scan_request(request_id: ScanRequestId, command: DrawCommand) -> ScanRequestView:
    """Vehicles keep no more scans for it. What they have kept still comes."""
    return await command.transact(
        ScanRequestView, lambda uow: _view(uow, scans.end_request(uow, request_id, command.by))
    )


def _view(uow: UnitOfWork, request: ScanRequest) -> ScanRequestView:
    reason = scans.state_at(request, uow.now)
    state: Literal["open", "operator", "time", "size"] = reason or "open"
    parcels = uow.scans.parcels(request.request_id)
    return request_view(request, state, uow.scans.contributions(request.request_id), parcels)
