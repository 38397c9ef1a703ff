"""Incidents, the most urgent first."""

from typing import Annotated

from fastapi import APIRouter, Query

from server.api.formats import IncidentId
from server.api.incidents.schemas import IncidentView
from server.api.problems import CsrfMissing, problems
from server.api.security.access import ChangingOperator, ReadingOperator
from server.api.services import InjectedServices
from server.domain.errors import IncidentClosed, IncidentUnknown, SessionExpired
from server.domain.record.incidents import Incident
from server.usecases.record import incidents

router = APIRouter(prefix="/incidents", tags=["incidents"])


@router.get("", operation_id="list_incidents", responses=problems(SessionExpired))
async def list_incidents(
    services: InjectedServices,
    _: ReadingOperator,
    closed: Annotated[bool, Query(description="Also those that are closed, after the open ones.")] = False,
    limit: Annotated[int, Query(ge=1, le=500)] = 200,
) -> list[IncidentView]:
    """Open ones by urgency and age, then closed ones, newest first."""
    found = await services.transactions.read(
        lambda uow: uow.views.incidents(include_closed=closed, limit=limit)
    )
    return [incident_view(incident) for incident in found]


@router.post(
    "/{incident_id}/acknowledge",
    operation_id="acknowledge_incident",
    responses=problems(IncidentUnknown, IncidentClosed, SessionExpired, CsrfMissing),
)
async def acknowledge_incident(
    incident_id: IncidentId, services: InjectedServices, operator: ChangingOperator
) -> IncidentView:
    """Say that an operator handles it. A repeat keeps the first name."""
    return incident_view(
        await services.transactions.run(lambda uow: incidents.acknowledge(uow, incident_id, operator.name))
    )


@router.post(
    "/{incident_id}/close",
    operation_id="close_incident",
    responses=problems(IncidentUnknown, IncidentClosed, SessionExpired, CsrfMissing),
)
async def close_incident(
    incident_id: IncidentId, services: InjectedServices, operator: ChangingOperator
) -> IncidentView:
    return incident_view(
        await services.transactions.run(lambda uow: incidents.close(uow, incident_id, operator.name))
    )


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
