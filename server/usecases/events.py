"""Take in what vehicles say has happened: each event once, in order."""

from contract.wire.sequence import is_new
from server.domain.events import RecordedEvent
from server.usecases.ports import EventStore


def record_event(events: EventStore, event: RecordedEvent) -> bool:
    """Store the event; False when it was stored before, so that its effects are not repeated.

    Raises SequenceGap when an earlier event of the boot is missing.
    """
    if not is_new(events.count(event.vehicle_id, event.boot_id), event.boot_id, event.sequence):
        return False
    events.add(event)
    return True
