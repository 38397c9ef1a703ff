"""Take in what vehicles say has happened: each event once, in order."""

from dataclasses import dataclass

from contract.wire.sequence import is_new
from server.domain.events import RecordedEvent
from server.usecases.ports import EventStore, UnitOfWork


@dataclass(frozen=True, slots=True)
class Effects:
    """is_new is False for a repeat. next_sequence: every event of the boot below it is stored."""

    is_new: bool
    next_sequence: int


def record_event(events: EventStore, event: RecordedEvent) -> bool:
    """Store the event; False when it was stored before, so that its effects are not repeated.

    Raises SequenceGap when an earlier event of the boot is missing.
    """
    if not is_new(events.count(event.vehicle_id, event.boot_id), event.boot_id, event.sequence):
        return False
    events.add(event)
    return True


def apply_event(uow: UnitOfWork, event: RecordedEvent) -> Effects:
    """Store the event and let it have its effect, once. Raises SequenceGap, VehicleUnknown."""
    raise NotImplementedError
