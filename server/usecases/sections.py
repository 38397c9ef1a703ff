"""Leave to enter the road ahead. Every grant and every route goes through the reservation controller."""

from contract.wire.messages import SectionGrant
from server.usecases.ports import UnitOfWork


def extend_grants(uow: UnitOfWork) -> tuple[str, ...]:
    """Retry routes that were not safe, then grant every vehicle the road ahead; the vehicles that gained."""
    raise NotImplementedError


def grants_of(uow: UnitOfWork, vehicle_id: str) -> tuple[SectionGrant, ...]:
    """What the vehicle holds, in route order."""
    raise NotImplementedError
