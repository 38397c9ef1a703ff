"""Roads closed by operators."""

from typing import Annotated

from fastapi import APIRouter, Path

from server.api.closures.schemas import (
    ClosureBody,
    ClosureView,
    closure_request,
    closure_view,
)
from server.api.formats import NAME_PATTERN
from server.api.problems import CsrfMissing, problems
from server.api.security.access import ChangingOperator, ReadingOperator
from server.api.services import InjectedServices
from server.domain.errors import (
    CampusUnknown,
    ClosureInvalid,
    ClosureOver,
    ClosureUnknown,
    LaneUnknown,
    SectionUnknown,
    SessionExpired,
)
from server.usecases.fleet import closures
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/closures", tags=["closures"])

ClosureId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["closure-2"])]


@router.get("", operation_id="list_closures", responses=problems(SessionExpired, CampusUnknown))
async def list_closures(services: InjectedServices, _: ReadingOperator) -> list[ClosureView]:
    """Those that hold now and those to come, by their beginning."""

    def work(uow: UnitOfWork) -> list[ClosureView]:
        return [closure_view(closure, uow.network()) for closure in uow.closures.standing()]

    return await services.transactions.read(work)


@router.post(
    "",
    operation_id="close_road",
    status_code=201,
    responses=problems(
        LaneUnknown, SectionUnknown, ClosureInvalid, CampusUnknown, SessionExpired, CsrfMissing
    ),
)
async def close_road(
    body: ClosureBody, services: InjectedServices, operator: ChangingOperator
) -> ClosureView:
    """From its beginning on, no vehicle is sent there. Rides that this cuts off are postponed, let out at
    another stop, or ended; their passengers see it at once."""

    def work(uow: UnitOfWork) -> ClosureView:
        return closure_view(closures.close(uow, closure_request(body), operator.name), uow.network())

    return await services.transactions.run(work)


@router.delete(
    "/{closure_id}",
    operation_id="lift_closure",
    status_code=204,
    responses=problems(ClosureUnknown, ClosureOver, CampusUnknown, SessionExpired, CsrfMissing),
)
async def lift_closure(closure_id: ClosureId, services: InjectedServices, operator: ChangingOperator) -> None:
    """The road is open again, or will not be closed."""
    await services.transactions.run(lambda uow: closures.lift(uow, closure_id, operator.name))
