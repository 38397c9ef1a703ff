"""Plans made into orders on the wire, and the vehicle's answers to them."""

from contract.wire.messages import OrderRejected
from server.domain.orders import IssuedOrder
from server.usecases.ports import UnitOfWork


def reissue(uow: UnitOfWork, vehicle_id: str) -> IssuedOrder | None:
    """Make the vehicle's order carry out its plan, if its new route is safe now; None when nothing changed.

    While the route is not safe the old order stays in force; the next release tries again.
    Raises VehicleUnknown.
    """
    raise NotImplementedError


def accepted(uow: UnitOfWork, vehicle_id: str, order_id: str, revision: int) -> None:
    """The vehicle has it on disk. A repeat is harmless. Raises OrderUnknown."""
    raise NotImplementedError


def rejected(uow: UnitOfWork, vehicle_id: str, answer: OrderRejected) -> IssuedOrder | None:
    """The vehicle keeps what it had: take over its word on its visits and issue anew.

    The same rejection three times in a row opens an incident and stops the repetition.
    Raises OrderUnknown.
    """
    raise NotImplementedError


def current_order(uow: UnitOfWork, vehicle_id: str) -> IssuedOrder | None:
    """The order in force, whatever its state."""
    raise NotImplementedError
