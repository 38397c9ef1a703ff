"""Operators' interventions: previewed before anybody is told, and reassignments."""

from fastapi import APIRouter

from server.api.formats import VehicleId
from server.api.interventions.dry_run import rehearsed
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
from server.domain.rides.effects import Intervention
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
    vehicle_id: VehicleId, wish: InterventionRequest, services: InjectedServices, operator: ChangingOperator
) -> EffectsView:
    """Whom it would delay by how much. Nothing changes; doing it then yields this, if nothing else does."""
    asked = intervention(wish)
    done = await rehearsed(
        services.transactions, lambda uow: intervene(uow, vehicle_id, asked, operator.name)
    )
    return effects_view(done.effects)


@router.post("/{vehicle_id}/reassign", operation_id="reassign_rides", responses=_REFUSED)
async def reassign_rides(
    vehicle_id: VehicleId, wish: Reassignment, services: InjectedServices, operator: ChangingOperator
) -> EffectsView:
    """Give the rides that wait for this vehicle, or one of them, to others, which keep them."""
    asked = Intervention("reassign", ride_id=wish.ride_id, to_vehicle_id=wish.to_vehicle_id)
    done = await services.transactions.run(lambda uow: intervene(uow, vehicle_id, asked, operator.name))
    return effects_view(done.effects)
