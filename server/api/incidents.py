"""What operators have to look at, the most urgent on top."""

from datetime import datetime
from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict, Field

from server.api.access import ChangingOperator, ReadingOperator
from server.api.formats import IncidentId
from server.api.problems import CsrfMissing, problems
from server.api.services import Given
from server.domain.errors import IncidentClosed, IncidentUnknown, SessionExpired
from server.domain.incidents import Incident, IncidentKind
from server.usecases import incidents

router = APIRouter(prefix="/incidents", tags=["incidents"])


class IncidentView(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "incident_id": "incident-19",
                "kind": "help_call",
                "priority": 0,
                "cause": "The door does not open.",
                "opened_at": "2026-09-01T08:20:11Z",
                "vehicle_id": "shuttle-1",
                "ride_id": "ride-5f2c",
                "acknowledged_at": None,
                "acknowledged_by": "",
                "closed_at": None,
                "closed_by": "",
            }
        }
    )

    incident_id: str
    kind: IncidentKind
    priority: int = Field(description="Lower is more urgent; a call for help is 0.")
    cause: str
    opened_at: datetime
    vehicle_id: str | None
    ride_id: str | None
    acknowledged_at: datetime | None
    acknowledged_by: str
    closed_at: datetime | None
    closed_by: str


@router.get("", operation_id="list_incidents", responses=problems(SessionExpired))
async def list_incidents(
    services: Given,
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
    incident_id: IncidentId, services: Given, operator: ChangingOperator
) -> IncidentView:
    """I look after it. A repeat keeps the first name."""
    return incident_view(
        await services.transactions.run(lambda uow: incidents.acknowledge(uow, incident_id, operator.name))
    )


@router.post(
    "/{incident_id}/close",
    operation_id="close_incident",
    responses=problems(IncidentUnknown, IncidentClosed, SessionExpired, CsrfMissing),
)
async def close_incident(
    incident_id: IncidentId, services: Given, operator: ChangingOperator
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
