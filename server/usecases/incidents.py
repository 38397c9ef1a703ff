"""What operators look at: opened by the server, acknowledged and closed by people."""

from server.domain.incidents import Incident, IncidentKind
from server.usecases.ports import UnitOfWork


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
    raise NotImplementedError


def clear_incident(uow: UnitOfWork, kind: IncidentKind, subject: str) -> None:
    """The cause is gone: close the incident by the server's own word, if it is open."""
    raise NotImplementedError


def acknowledge(uow: UnitOfWork, incident_id: str, by: str) -> Incident:
    """Raises IncidentUnknown, IncidentClosed."""
    raise NotImplementedError


def close(uow: UnitOfWork, incident_id: str, by: str) -> Incident:
    """Raises IncidentUnknown, IncidentClosed."""
    raise NotImplementedError


def list_open(uow: UnitOfWork) -> tuple[Incident, ...]:
    """Most urgent first, then oldest."""
    raise NotImplementedError
