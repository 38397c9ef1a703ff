"""When vehicles are on duty."""

from fastapi import APIRouter

from server.api.commands import ServiceCommand
from server.api.formats import VehicleId
from server.api.problems import problems
from server.api.security.access import OPERATOR_REFUSALS, READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.api.shifts.schemas import ShiftsModel, shifts_model, shifts_of
from server.domain.errors import ShiftsInvalid, VehicleUnknown
from server.usecases.fleet import vehicles
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

router = APIRouter(prefix="/vehicles/{vehicle_id}/shifts", tags=["vehicles"])


@router.get("", operation_id="get_vehicle_shifts", responses=problems(VehicleUnknown, *READER_REFUSALS))
async def get_vehicle_shifts(
    vehicle_id: VehicleId, services: InjectedServices, _: Reader
) -> ShiftsModel | None:
    """Null: always on duty."""
    vehicle = await services.transactions.read(lambda uow: enrolled_vehicle(uow, vehicle_id))
    return None if vehicle.shifts is None else shifts_model(vehicle.shifts)


@router.put(
    "",
    operation_id="put_vehicle_shifts",
    responses=problems(VehicleUnknown, ShiftsInvalid, *OPERATOR_REFUSALS),
)
async def put_vehicle_shifts(
    vehicle_id: VehicleId, body: ShiftsModel, command: ServiceCommand
) -> ShiftsModel:
    """Replace the vehicle's shifts. Promised rides are kept."""

    def work(uow: UnitOfWork) -> ShiftsModel:
        vehicles.set_shifts(uow, vehicle_id, shifts_of(body), command.by)
        return body

    return await command.transact(ShiftsModel, work)


@router.delete(
    "",
    operation_id="delete_vehicle_shifts",
    status_code=204,
    responses=problems(VehicleUnknown, *OPERATOR_REFUSALS),
)
async def delete_vehicle_shifts(vehicle_id: VehicleId, command: ServiceCommand) -> None:
    """Remove the shifts: the vehicle is always on duty."""

    def work(uow: UnitOfWork) -> None:
        vehicles.set_shifts(uow, vehicle_id, None, command.by)

    await command.transact(type(None), work)
