"""The vehicle link as the server's record sees it: sessions, positions, silence."""

from collections.abc import Sequence
from dataclasses import dataclass

from contract.wire.messages import BootLog, Holding
from server.domain.vehicles import StatusReport, VehicleSession
from server.usecases.ports import UnitOfWork


@dataclass(frozen=True, slots=True)
class HelloFacts:
    """What a verified hello says."""

    vehicle_id: str
    boot_id: str
    software: str
    stack: str
    map_version: str
    logs: tuple[BootLog, ...]
    holding: Holding | None
    seats: int
    wheelchair_places: int


def open_session(uow: UnitOfWork, hello: HelloFacts) -> VehicleSession:
    """A new epoch; older sessions are fenced. The vehicle's word on its visits is taken over.

    The hub applies the boot's unacknowledged events next and sends the outbox after them.
    Raises VehicleUnknown.
    """
    raise NotImplementedError


def close_session(uow: UnitOfWork, vehicle_id: str, epoch: int) -> None:
    """The link is gone. An older epoch's end is no news."""
    raise NotImplementedError


def require_epoch(uow: UnitOfWork, vehicle_id: str, epoch: int) -> None:
    """Raises SessionFenced when a newer session has taken over."""
    raise NotImplementedError


def report_key_conflict(uow: UnitOfWork, vehicle_id: str, detail: str) -> None:
    """Two agents speak with one key: an incident."""
    raise NotImplementedError


def record_status(uow: UnitOfWork, reports: Sequence[StatusReport]) -> None:
    """Keep a batch of positions. A vehicle's first position on a lane places it on the road."""
    raise NotImplementedError


def note_silence(uow: UnitOfWork) -> tuple[str, ...]:
    """Open an incident for each vehicle that has fallen silent, close those heard again; the silent ones."""
    raise NotImplementedError
