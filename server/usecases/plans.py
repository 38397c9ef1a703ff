"""How the fleet is assigned: every change of a vehicle's plan goes through here."""

from server.domain.plans import Plan
from server.domain.rides import Ride
from server.usecases.ports import UnitOfWork


def plan_of(uow: UnitOfWork, vehicle_id: str) -> Plan:
    """Raises VehicleUnknown."""
    raise NotImplementedError


def assign_waiting(uow: UnitOfWork) -> tuple[Ride, ...]:
    """Give every ride that has lost its vehicle to another one; answers those that got one."""
    raise NotImplementedError


def send_to_stop(uow: UnitOfWork, vehicle_id: str, stop_id: str, by: str) -> Plan:
    """Have a vehicle visit a stop after what it has promised already (developer, operator).

    Raises VehicleUnknown, VehicleNotPlaced, VehicleOutOfService, StopUnknown, StopUnreachable.
    """
    raise NotImplementedError
