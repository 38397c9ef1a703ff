"""Operators' interventions: previews, and reassignments."""

from fastapi import APIRouter

from server.api.formats import VehicleId
from server.api.interventions.dry_run import dry_run
from server.api.interventions.schemas import (
    EffectsView,
    InterventionRequest,
    Reassignment,
    effects_view,
    intervention,
)
from server.api.problems import CsrfMissing, problems
from server.api.security.access import ChangingOperator
from server.api.services import InjectedServices
from server.domain.errors import (
    NoRestingPlaceFree,
    ReassignmentRefused,
    RideAlreadyAboard,
    RideEnded,
    RideNotAssigned,
    RideUnknown,
    SessionExpired,
    VehicleUnknown,
)
from server.usecases.fleet import vehicle_commands
from server.usecases.fleet.interventions import intervene

router = APIRouter(prefix="/vehicles", tags=["vehicles"])

_REFUSED = problems(
    VehicleUnknown,
    RideUnknown,
    RideNotAssigned,
    RideAlreadyAboard,
    RideEnded,
    ReassignmentRefused,
    NoRestingPlaceFree,
    SessionExpired,
    CsrfMissing,
)


@router.post("/{vehicle_id}/previews", operation_id="preview_intervention", responses=_REFUSED)
async def preview_intervention(
    vehicle_id: VehicleId,
    request: InterventionRequest,
    services: InjectedServices,
    operator: ChangingOperator,
) -> EffectsView:
    """The effects that it would have. Nothing changes. The intervention has these effects if the fleet does
    not change in between."""
    previewed = intervention(request)
    result = await dry_run(
        services.transactions, lambda uow: intervene(uow, vehicle_id, previewed, operator.name)
    )
    return effects_view(result.effects)


@router.post("/{vehicle_id}/reassign", operation_id="reassign_rides", responses=_REFUSED)
async def reassign_rides(
    vehicle_id: VehicleId, request: Reassignment, services: InjectedServices, operator: ChangingOperator
) -> EffectsView:
    """Give the rides that wait for this vehicle, or one of them, to others, which keep them."""
    return effects_view(
        await vehicle_commands.reassign(
            services.transactions, vehicle_id, request.ride_id, request.to_vehicle_id, operator.name
        )
    )
