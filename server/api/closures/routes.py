"""Roads closed by operators."""

from typing import Annotated

from fastapi import APIRouter, Depends, Path

from server.api.closures.schemas import (
    ClosureBody,
    ClosureView,
    closure_request,
    closure_view,
)
from server.api.commands import DispatchCommand
from server.api.formats import NAME_PATTERN
from server.api.interventions.schemas import EffectsView, effects_view
from server.api.paging import ListLimit, Page, microseconds_of, paged
from server.api.problems import problems
from server.api.security.access import (
    DRIVER_REFUSALS,
    READER_REFUSALS,
    Actor,
    Reader,
    changing,
)
from server.api.security.permissions import DISPATCH
from server.api.services import InjectedServices
from server.domain.errors import (
    CampusUnknown,
    ClosureInvalid,
    ClosureOver,
    ClosureUnknown,
    LaneUnknown,
    SectionUnknown,
)
from server.usecases.fleet import closures
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.dry_run import roll_back

router = APIRouter(prefix="/closures", tags=["closures"])

ClosureId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["closure-2"])]


@router.get(
    "",
    operation_id="list_closures",
    responses=paged(CampusUnknown, *READER_REFUSALS),
)
async def list_closures(
    services: InjectedServices, _: Reader, page: Page, limit: ListLimit = None
) -> list[ClosureView]:
    """Those that hold now and those to come, by their beginning."""

    def work(uow: UnitOfWork) -> list[ClosureView]:
        return [closure_view(closure, uow.network()) for closure in uow.closures.standing()]

    found = await services.transactions.read(work)
    return page.cut(found, limit, lambda closure: (microseconds_of(closure.starts_at), closure.closure_id))


@router.post(
    "",
    operation_id="close_road",
    status_code=201,
    responses=problems(LaneUnknown, SectionUnknown, ClosureInvalid, CampusUnknown, *DRIVER_REFUSALS),
)
async def close_road(body: ClosureBody, command: DispatchCommand) -> ClosureView:
    """From its beginning on, no vehicle is sent there. Rides that this cuts off are postponed, let out at
    another stop, or ended; their passengers see it at once."""

    def work(uow: UnitOfWork) -> ClosureView:
        return closure_view(closures.close(uow, closure_request(body), command.by), uow.network())

    return await command.transact(ClosureView, work)


@router.post(
    "/previews",
    operation_id="preview_closure",
    responses=problems(LaneUnknown, SectionUnknown, ClosureInvalid, CampusUnknown, *DRIVER_REFUSALS),
)
async def preview_closure(
    body: ClosureBody, services: InjectedServices, actor: Annotated[Actor, Depends(changing(DISPATCH))]
) -> EffectsView:
    """The effects that the closure would have. Nothing changes. The closure has these effects if the fleet
    does not change in between."""
    effects = await roll_back(
        services.transactions,
        lambda uow: closures.close_with_effects(uow, closure_request(body), actor.name),
    )
    return effects_view(effects)


@router.delete(
    "/{closure_id}",
    operation_id="lift_closure",
    status_code=204,
    responses=problems(ClosureUnknown, ClosureOver, CampusUnknown, *DRIVER_REFUSALS),
)
async def lift_closure(closure_id: ClosureId, command: DispatchCommand) -> None:
    """The road is open again, or will not be closed."""

    def work(uow: UnitOfWork) -> None:
        closures.lift(uow, closure_id, command.by)

    await command.transact(type(None), work)
