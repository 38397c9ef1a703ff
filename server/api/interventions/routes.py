"""Operators' interventions: previews, and reassignments."""

from typing import Annotated

from fastapi import APIRouter, Depends

from server.api.commands import DispatchCommand
from server.api.formats import VehicleId
from server.api.interventions.schemas import (
    EffectsView,
    InterventionRequest,
    Reassignment,
    effects_view,
    intervention,
)
from server.api.problems import problems
from server.api.security.access import DRIVER_REFUSALS, Actor, changing
from server.api.security.permissions import PREVIEW
from server.api.services import InjectedServices
from server.domain.errors import (
    NoRestingPlaceFree,
    ReassignmentRefused,
    RideAlreadyAboard,
    RideEnded,
    RideNotAssigned,
    RideUnknown,
    VehicleUnknown,
)
from server.usecases.fleet import vehicle_commands
from server.usecases.fleet.interventions import intervene
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.dry_run import roll_back

router = APIRouter(prefix="/vehicles", tags=["vehicles"])

_REFUSED = problems(
    VehicleUnknown,
    RideUnknown,
    RideNotAssigned,
    RideAlreadyAboard,
    RideEnded,
    ReassignmentRefused,
    NoRestingPlaceFree,
    *DRIVER_REFUSALS,
)


@router.post("/{vehicle_id}/previews", operation_id="preview_intervention", responses=_REFUSED)
async def preview_intervention(
    vehicle_id: VehicleId,
    request: InterventionRequest,
    services: InjectedServices,
    actor: Annotated[Actor, Depends(changing(PREVIEW))],
) -> EffectsView:
    """The effects that it would have. Nothing changes. The intervention has these effects if the fleet does
    not change in between."""
    previewed = intervention(request)
    result = await roll_back(
        services.transactions, lambda uow: intervene(uow, vehicle_id, previewed, actor.name)
    )
    return effects_view(result.effects)


@router.post("/{vehicle_id}/reassign", operation_id="reassign_rides", responses=_REFUSED)
async def reassign_rides(
    vehicle_id: VehicleId, request: Reassignment, command: DispatchCommand
) -> EffectsView:
    """Give the rides that wait for this vehicle, or one of them, to others, which keep them."""

    def work(uow: UnitOfWork) -> EffectsView:
        return effects_view(
            vehicle_commands.reassign(uow, vehicle_id, request.ride_id, request.to_vehicle_id, command.by)
        )

    return await command.transact(EffectsView, work)
