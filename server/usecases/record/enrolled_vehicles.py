"""Vehicles by id."""

from server.domain.errors import VehicleUnknown
from server.domain.fleet.vehicles import Vehicle
from server.usecases.ports.unit_of_work import UnitOfWork


def enrolled_vehicle(uow: UnitOfWork, vehicle_id: str) -> Vehicle:
    """A vehicle, retired ones included. Raises VehicleUnknown."""
    vehicle = uow.vehicles.get(vehicle_id)
    if vehicle is None:
        raise VehicleUnknown(f"no vehicle {vehicle_id} is enrolled")
    return vehicle


def active_vehicle(uow: UnitOfWork, vehicle_id: str) -> Vehicle:
    """A vehicle that is not retired. Raises VehicleUnknown."""
    vehicle = enrolled_vehicle(uow, vehicle_id)
    if vehicle.retired:
        raise VehicleUnknown(f"no vehicle {vehicle_id} is enrolled")
    return vehicle
