"""Incidents as operators see them."""

from datetime import datetime
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from server.api.formats import FreeText
from server.domain.record.events import ServerEvent
from server.domain.record.incidents import IncidentKind


class NoteRequest(BaseModel):
    """What an operator writes."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"text": "The door was stuck; a technician comes."}}
    )

    text: Annotated[FreeText, Field(min_length=1)]


class NoteView(BaseModel):
    """Something that happened to an incident, or an entry of the shift log."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "happened_at": "2026-09-01T08:25:40Z",
                "name": "incident.noted",
                "by": "ann",
                "text": "The door was stuck; a technician comes.",
            }
        }
    )

    happened_at: datetime
    name: str
    by: str = Field(description="An operator, or empty for the server.")
    text: str


def note_view(event: ServerEvent) -> NoteView:
    return NoteView(happened_at=event.happened_at, name=event.name, by=event.by, text=event.detail)


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
