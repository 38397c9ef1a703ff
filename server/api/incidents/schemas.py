"""Incidents as operators see them."""

from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field

from server.domain.record.incidents import IncidentKind


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
