"""All that the server has to say to one vehicle now."""

from dataclasses import dataclass

from contract.wire.messages import Command, Grants, Order, PassengerTap
from server.usecases.ports import UnitOfWork


@dataclass(frozen=True, slots=True)
class Outbox:
    """order is None when the vehicle follows the newest one already; grants None while it has no order.

    Repeats are harmless to the vehicle; a session may leave out what it has sent already.
    """

    order: Order | None
    grants: Grants | None
    commands: tuple[Command, ...]
    taps: tuple[PassengerTap, ...]


def outbox_of(uow: UnitOfWork, vehicle_id: str) -> Outbox:
    """Order, grants, commands and taps, stamped with the vehicle's epoch. Raises VehicleUnknown."""
    raise NotImplementedError
