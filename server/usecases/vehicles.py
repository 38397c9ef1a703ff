"""Enrolling, placing, recalling and retiring vehicles."""

from server.domain.vehicles import Vehicle
from server.usecases.ports import UnitOfWork


def enrol(uow: UnitOfWork, code: str, vehicle_id: str, public_key: str) -> Vehicle:
    """Take in a vehicle's key, once, by a code that an operator made for it.

    public_key   Ed25519, 32 bytes, base64. Enrolling a known vehicle replaces its key.
    Raises EnrolmentCodeUnknown (also: made for another vehicle, or expired), EnrolmentCodeUsed, KeyInvalid.
    """
    raise NotImplementedError


def key_of(uow: UnitOfWork, vehicle_id: str) -> str:
    """The public key (base64) that the vehicle's hello must be signed with. Raises KeyUnknown."""
    raise NotImplementedError


def revoke_key(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """The key opens nothing any more, and the open session ends. Raises KeyUnknown."""
    raise NotImplementedError


def vehicle_of(uow: UnitOfWork, vehicle_id: str) -> Vehicle:
    """Raises VehicleUnknown."""
    raise NotImplementedError


def recall(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """Take it out of service: it brings home who is aboard, then rests; others get its waiting rides.

    Raises VehicleUnknown.
    """
    raise NotImplementedError


def return_to_service(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """It may get rides again. Raises VehicleUnknown."""
    raise NotImplementedError


def place(uow: UnitOfWork, vehicle_id: str, lane_id: str, s_m: float, by: str) -> Vehicle:
    """Say by hand where a held vehicle stands; it then holds the ground under its body.

    Raises VehicleUnknown, VehicleNotPlaced (no such lane), SectionsTaken.
    """
    raise NotImplementedError


def retire(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """Take it off the roads for good: its sections become free, its rides are given to others.

    Raises VehicleUnknown.
    """
    raise NotImplementedError
