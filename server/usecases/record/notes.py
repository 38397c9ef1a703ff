"""What operators write: notes on an incident, and the log that one shift leaves to the next.

They are events of the record, so that they stand in order among what happened; those on an incident about a
ride are erased with its rider.
"""

from server.domain.errors import IncidentUnknown
from server.domain.record.events import ServerEvent
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event

INCIDENT_NOTED = "incident.noted"
SHIFT_NOTED = "shift.noted"
# What the entries of the shift log are about.
SHIFT_LOG = "shift-log"


def note_on_incident(uow: UnitOfWork, incident_id: str, text: str, by: str) -> None:
    """Also on a closed one: what was found out is often written afterwards. Raises IncidentUnknown."""
    _require_incident(uow, incident_id)
    record_event(uow, INCIDENT_NOTED, incident_id, by, text)
    uow.publish(topics.incidents(uow.campus_id), incident_id=incident_id)


def incident_history(uow: UnitOfWork, incident_id: str) -> tuple[ServerEvent, ...]:
    """What happened to it, with its notes, oldest first. Raises IncidentUnknown."""
    _require_incident(uow, incident_id)
    return uow.views.events_about(incident_id)


def note_in_shift_log(uow: UnitOfWork, text: str, by: str) -> None:
    record_event(uow, SHIFT_NOTED, SHIFT_LOG, by, text)


def shift_log(uow: UnitOfWork, limit: int) -> tuple[ServerEvent, ...]:
    """The latest entries, oldest first."""
    return uow.views.events_about(SHIFT_LOG, limit)


def _require_incident(uow: UnitOfWork, incident_id: str) -> None:
    if uow.incidents.get(incident_id) is None:
        raise IncidentUnknown(f"there is no incident {incident_id}")
