"""When vehicles are on duty."""

from fastapi import APIRouter

from server.api.formats import VehicleId
from server.api.problems import CsrfMissing, problems
from server.api.security.access import ChangingOperator, ReadingOperator
from server.api.services import InjectedServices
from server.api.shifts.schemas import ShiftsModel, shifts_model, shifts_of
from server.domain.errors import SessionExpired, ShiftsInvalid, VehicleUnknown
from server.usecases.fleet import vehicles
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

router = APIRouter(prefix="/vehicles/{vehicle_id}/shifts", tags=["vehicles"])


@router.get("", operation_id="get_vehicle_shifts", responses=problems(VehicleUnknown, SessionExpired))
async def get_vehicle_shifts(
    vehicle_id: VehicleId, services: InjectedServices, _: ReadingOperator
) -> ShiftsModel | None:
    """Null: always on duty."""
    vehicle = await services.transactions.read(lambda uow: enrolled_vehicle(uow, vehicle_id))
    return None if vehicle.shifts is None else shifts_model(vehicle.shifts)


@router.put(
    "",
    operation_id="put_vehicle_shifts",
    responses=problems(VehicleUnknown, ShiftsInvalid, SessionExpired, CsrfMissing),
)
async def put_vehicle_shifts(
    vehicle_id: VehicleId, body: ShiftsModel, services: InjectedServices, operator: ChangingOperator
) -> ShiftsModel:
    """Replace the vehicle's shifts. Promised rides are kept."""
    await services.transactions.run(
        lambda uow: vehicles.set_shifts(uow, vehicle_id, shifts_of(body), operator.name)
    )
    return body


@router.delete(
    "",
    operation_id="delete_vehicle_shifts",
    status_code=204,
    responses=problems(VehicleUnknown, SessionExpired, CsrfMissing),
)
async def delete_vehicle_shifts(
    vehicle_id: VehicleId, services: InjectedServices, operator: ChangingOperator
) -> None:
    """Remove the shifts: the vehicle is always on duty."""
    await services.transactions.run(lambda uow: vehicles.set_shifts(uow, vehicle_id, None, operator.name))
