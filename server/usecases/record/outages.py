"""Failing standing tasks of the server as incidents: what is degraded, and since when."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from server.domain.record.incidents import IncidentKind
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import clear_incident, open_incident


@dataclass(frozen=True, slots=True)
class TaskOutage:
    """A standing task that fails or hangs. ended_at: when it worked again, None while it does not."""

    name: str
    since: datetime
    cause: str
    ended_at: datetime | None = None


def record_outages(
    uow: UnitOfWork, server_name: str, past: Sequence[TaskOutage], present: Sequence[TaskOutage]
) -> None:
    """Open an incident for each task of this server that fails now, and close those of its other tasks.

    past  outages that ended before they could be recorded: while they lasted nothing could be stored
    """
    for outage in past:
        subject = _open(uow, server_name, outage)
        clear_incident(uow, IncidentKind.SERVER_DEGRADED, subject)
    failing = {_open(uow, server_name, outage) for outage in present}
    for incident in uow.incidents.all_open():
        is_ours = incident.subject.startswith(f"{server_name}/")
        if incident.kind is IncidentKind.SERVER_DEGRADED and is_ours and incident.subject not in failing:
            clear_incident(uow, IncidentKind.SERVER_DEGRADED, incident.subject)


def _open(uow: UnitOfWork, server_name: str, outage: TaskOutage) -> str:
    """Open its incident, if none is open. Returns the incident's subject."""
    subject = f"{server_name}/{outage.name}"
    until = f" until {outage.ended_at:%H:%M:%S}" if outage.ended_at is not None else ""
    cause = f"{outage.name} has failed since {outage.since:%H:%M:%S}{until} UTC: {outage.cause}"
    open_incident(uow, IncidentKind.SERVER_DEGRADED, subject, cause)
    return subject
