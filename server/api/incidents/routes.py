"""Incidents, the most urgent first."""

from typing import Annotated

from fastapi import APIRouter, Depends, Query

from server.api.commands import IncidentCommand
from server.api.formats import IncidentId
from server.api.incidents.schemas import IncidentView, NoteRequest, NoteView, note_view
from server.api.paging import LIMIT_MAX, Page, Position, microseconds_of, moment_of, paged
from server.api.problems import problems
from server.api.security.access import (
    LOOKING_REFUSALS,
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    Actor,
    Reader,
    looking,
)
from server.api.security.permissions import READ_NOTES
from server.api.services import InjectedServices
from server.domain.errors import IncidentClosed, IncidentUnknown
from server.domain.record.incidents import Incident
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.ports.views import IncidentPosition
from server.usecases.record import incidents, notes

router = APIRouter(prefix="/incidents", tags=["incidents"])


@router.get("", operation_id="list_incidents", responses=paged(*READER_REFUSALS))
async def list_incidents(
    services: InjectedServices,
    _: Reader,
    page: Page,
    closed: Annotated[bool, Query(description="Also those that are closed, after the open ones.")] = False,
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 200,
) -> list[IncidentView]:
    """Open ones by urgency and age, then closed ones, newest first."""
    after = _after(page)
    found = await services.transactions.read(
        lambda uow: uow.views.incidents(include_closed=closed, limit=limit + 1, after=after)
    )
    return [incident_view(incident) for incident in page.first(found, limit, _position)]


@router.post(
    "/{incident_id}/acknowledge",
    operation_id="acknowledge_incident",
    responses=problems(IncidentUnknown, IncidentClosed, *OPERATOR_REFUSALS),
)
async def acknowledge_incident(incident_id: IncidentId, command: IncidentCommand) -> IncidentView:
    """Say that an operator handles it. A repeat keeps the first name."""
    return await command.transact(
        IncidentView, lambda uow: incident_view(incidents.acknowledge(uow, incident_id, command.by))
    )


@router.post(
    "/{incident_id}/close",
    operation_id="close_incident",
    responses=problems(IncidentUnknown, IncidentClosed, *OPERATOR_REFUSALS),
)
async def close_incident(incident_id: IncidentId, command: IncidentCommand) -> IncidentView:
    return await command.transact(
        IncidentView, lambda uow: incident_view(incidents.close(uow, incident_id, command.by))
    )


@router.get(
    "/{incident_id}/history",
    operation_id="incident_history",
    responses=problems(IncidentUnknown, *LOOKING_REFUSALS),
)
async def incident_history(
    incident_id: IncidentId, services: InjectedServices, _: Annotated[Actor, Depends(looking(READ_NOTES))]
) -> list[NoteView]:
    """What happened to it, with the operators' notes, oldest first."""
    found = await services.transactions.read(lambda uow: notes.incident_history(uow, incident_id))
    return [note_view(event) for event in found]


@router.post(
    "/{incident_id}/notes",
    operation_id="note_on_incident",
    status_code=201,
    responses=problems(IncidentUnknown, *OPERATOR_REFUSALS),
)
async def note_on_incident(
    incident_id: IncidentId, request: NoteRequest, command: IncidentCommand
) -> NoteRequest:
    """A note in the operator's name. It is erased with the rider of the incident's ride."""

    def work(uow: UnitOfWork) -> NoteRequest:
        notes.note_on_incident(uow, incident_id, request.text, command.by)
        return request

    return await command.transact(NoteRequest, work)


def _position(incident: Incident) -> Position:
    closed = -1 if incident.closed_at is None else microseconds_of(incident.closed_at)
    return (incident.priority, closed, microseconds_of(incident.opened_at), incident.incident_id)


def _after(page: Page) -> IncidentPosition | None:
    """Raises CursorInvalid."""
    after = page.after(int, int, int, str)
    if after is None:
        return None
    priority, closed, opened, incident_id = after
    closed_at = None if closed == -1 else moment_of(closed)
    return IncidentPosition(int(priority), closed_at, moment_of(opened), str(incident_id))


def incident_view(incident: Incident) -> IncidentView:
    return IncidentView(
        incident_id=incident.incident_id,
        kind=incident.kind,
        priority=incident.priority,
        cause=incident.cause,
        opened_at=incident.opened_at,
        vehicle_id=incident.vehicle_id,
        ride_id=incident.ride_id,
        acknowledged_at=incident.acknowledged_at,
        acknowledged_by=incident.acknowledged_by,
        closed_at=incident.closed_at,
        closed_by=incident.closed_by,
    )
