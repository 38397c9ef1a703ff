"""Incidents: the server opens them, and operators acknowledge and close them."""

from server.domain.errors import IncidentUnknown
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.record.incidents import acknowledged as as_acknowledged
from server.domain.record.incidents import closed as as_closed
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.commands import send_command
from server.usecases.record.server_events import THE_SERVER, record_event


def open_incident(
    uow: UnitOfWork,
    kind: IncidentKind,
    subject: str,
    cause: str,
    *,
    vehicle_id: str | None = None,
    ride_id: str | None = None,
) -> Incident:
    """The open incident of this kind about this subject, a new one if there is none."""
    known = uow.incidents.open_about(kind, subject)
    if known is not None:
        return known
    incident = Incident(
        campus_id=uow.campus_id,
        incident_id=uow.ids.new_id("incident"),
        kind=kind,
        subject=subject,
        cause=cause,
        opened_at=uow.now,
        vehicle_id=vehicle_id,
        ride_id=ride_id,
    )
    uow.incidents.add(incident)
    _record_and_publish(uow, incident, "incident.opened", THE_SERVER)
    return incident


def clear_incident(uow: UnitOfWork, kind: IncidentKind, subject: str) -> None:
    """The cause is gone: the server closes the incident, if it is open."""
    known = uow.incidents.open_about(kind, subject)
    if known is not None:
        _close(uow, known, THE_SERVER)


# Said and shown on board when an operator takes a call for help.
CALL_TAKEN = "An operator has seen your call for help. 运营人员已收到您的求助。"


def acknowledge(uow: UnitOfWork, incident_id: str, by: str) -> Incident:
    """The operator handles it; a caller aboard is told so at once. Raises IncidentUnknown, IncidentClosed."""
    known = _incident(uow, incident_id)
    incident = as_acknowledged(known, by, uow.now)
    uow.incidents.save(incident)
    is_call_aboard = incident.kind is IncidentKind.HELP_CALL and incident.subject == incident.vehicle_id
    if is_call_aboard and known.acknowledged_at is None:
        send_command(uow, incident.subject, "announce", by, CALL_TAKEN)
    _record_and_publish(uow, incident, "incident.acknowledged", by)
    return incident


def close(uow: UnitOfWork, incident_id: str, by: str) -> Incident:
    """Raises IncidentUnknown, IncidentClosed."""
    return _close(uow, _incident(uow, incident_id), by)


def _close(uow: UnitOfWork, incident: Incident, by: str) -> Incident:
    done = as_closed(incident, by, uow.now)
    uow.incidents.save(done)
    _record_and_publish(uow, done, "incident.closed", by)
    return done


def _incident(uow: UnitOfWork, incident_id: str) -> Incident:
    incident = uow.incidents.get(incident_id)
    if incident is None:
        raise IncidentUnknown(f"there is no incident {incident_id}")
    return incident


def _record_and_publish(uow: UnitOfWork, incident: Incident, name: str, by: str) -> None:
    detail = f"{incident.kind} {incident.subject}: {incident.cause}"
    record_event(uow, name, incident.incident_id, by, detail)
    uow.publish(topics.incidents(uow.campus_id), incident_id=incident.incident_id, kind=str(incident.kind))
