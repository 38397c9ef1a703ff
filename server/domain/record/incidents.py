"""Incidents that operators must know of, by urgency."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum

from server.domain.errors import IncidentClosed


class IncidentKind(StrEnum):
    HELP_CALL = "help_call"
    IMPOSSIBLE_POSITION = "impossible_position"
    GROUND_CONFLICT = "ground_conflict"
    KEY_CONFLICT = "key_conflict"
    MINIMAL_RISK_STOP = "minimal_risk_stop"
    TAKEOVER = "takeover"
    VEHICLE_BLOCKED = "vehicle_blocked"
    VEHICLE_SILENT = "vehicle_silent"
    VEHICLE_FAULT = "vehicle_fault"
    PROTOCOL_VIOLATION = "protocol_violation"
    FALSE_REPORT = "false_report"
    SERVER_DEGRADED = "server_degraded"
    BATTERY_LOW = "battery_low"
    RIDER_DID_NOT_ALIGHT = "rider_did_not_alight"
    MAP_NOT_CHANGED = "map_not_changed"
    LOCALIZATION_MAP_NOT_CHANGED = "localization_map_not_changed"
    NO_RESTING_PLACE = "no_resting_place"
    ROAD_CLOSED = "road_closed"
    ORDER_REJECTED = "order_rejected"
    DEPARTURE_MISSED = "departure_missed"
    TRIPS_UNSERVED = "trips_unserved"
    PROMISE_BROKEN = "promise_broken"
    RIDE_FAILED = "ride_failed"
    SEAT_BUTTON = "seat_button"
    WEBHOOK_DISABLED = "webhook_disabled"


# Lower is more urgent: people, then danger on the road, then vehicles standing, then service.
PRIORITY: Mapping[IncidentKind, int] = {
    IncidentKind.HELP_CALL: 0,
    IncidentKind.IMPOSSIBLE_POSITION: 10,
    IncidentKind.GROUND_CONFLICT: 11,
    IncidentKind.KEY_CONFLICT: 12,
    IncidentKind.SERVER_DEGRADED: 13,
    IncidentKind.FALSE_REPORT: 14,
    IncidentKind.PROTOCOL_VIOLATION: 15,
    IncidentKind.MINIMAL_RISK_STOP: 20,
    IncidentKind.TAKEOVER: 21,
    IncidentKind.VEHICLE_BLOCKED: 22,
    IncidentKind.VEHICLE_SILENT: 23,
    IncidentKind.VEHICLE_FAULT: 24,
    IncidentKind.BATTERY_LOW: 25,
    IncidentKind.RIDER_DID_NOT_ALIGHT: 30,
    IncidentKind.MAP_NOT_CHANGED: 34,
    IncidentKind.NO_RESTING_PLACE: 35,
    IncidentKind.ROAD_CLOSED: 36,
    IncidentKind.LOCALIZATION_MAP_NOT_CHANGED: 37,
    IncidentKind.ORDER_REJECTED: 40,
    IncidentKind.RIDE_FAILED: 41,
    IncidentKind.DEPARTURE_MISSED: 42,
    IncidentKind.PROMISE_BROKEN: 43,
    IncidentKind.TRIPS_UNSERVED: 44,
    IncidentKind.SEAT_BUTTON: 50,
    IncidentKind.WEBHOOK_DISABLED: 51,
}


# Of an incident about a rider who was erased.
ERASED_CAUSE = "erased with the ride"


@dataclass(frozen=True, slots=True)
class Incident:
    """subject names what the incident is about, so that one cause opens one incident at a time."""

    campus_id: str
    incident_id: str
    kind: IncidentKind
    subject: str
    cause: str
    opened_at: datetime
    vehicle_id: str | None = None
    ride_id: str | None = None
    acknowledged_at: datetime | None = None
    acknowledged_by: str = ""
    closed_at: datetime | None = None
    closed_by: str = ""

    @property
    def priority(self) -> int:
        return PRIORITY[self.kind]

    @property
    def is_open(self) -> bool:
        return self.closed_at is None


def acknowledged(incident: Incident, by: str, at: datetime) -> Incident:
    """An operator handles the incident; a repeat keeps the first name. Raises IncidentClosed."""
    if not incident.is_open:
        raise IncidentClosed(f"incident {incident.incident_id} was closed by {incident.closed_by}")
    if incident.acknowledged_at is not None:
        return incident
    return replace(incident, acknowledged_at=at, acknowledged_by=by)


def closed(incident: Incident, by: str, at: datetime) -> Incident:
    """Raises IncidentClosed."""
    if not incident.is_open:
        raise IncidentClosed(f"incident {incident.incident_id} was closed by {incident.closed_by}")
    return replace(incident, closed_at=at, closed_by=by)
