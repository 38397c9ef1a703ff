from datetime import UTC, datetime

import pytest

from server.domain.errors import IncidentClosed
from server.domain.record.incidents import (
    PRIORITY,
    Incident,
    IncidentKind,
    acknowledged,
    closed,
)

K = IncidentKind
NOW = datetime(2026, 11, 23, 8, 0, tzinfo=UTC)


def an_incident(kind: IncidentKind = IncidentKind.TAKEOVER) -> Incident:
    return Incident("campus", "incident-1", kind, "shuttle-1", "why", NOW)


def test_every_kind_has_its_own_urgency_and_a_help_call_comes_first() -> None:
    assert set(PRIORITY) == set(IncidentKind)
    assert len(set(PRIORITY.values())) == len(PRIORITY)
    assert min(PRIORITY, key=lambda kind: PRIORITY[kind]) is IncidentKind.HELP_CALL


def test_people_come_before_danger_on_the_road_before_shuttles_that_stand_before_service() -> None:
    order = sorted(PRIORITY, key=lambda kind: PRIORITY[kind])
    assert order == [
        K.HELP_CALL,
        *(K.IMPOSSIBLE_POSITION, K.GROUND_CONFLICT, K.KEY_CONFLICT),
        *(K.SERVER_DEGRADED, K.FALSE_REPORT, K.PROTOCOL_VIOLATION),
        *(
            K.MINIMAL_RISK_STOP,
            K.TAKEOVER,
            K.VEHICLE_BLOCKED,
            K.VEHICLE_SILENT,
            K.VEHICLE_FAULT,
            K.BATTERY_LOW,
        ),
        *(K.RIDER_DID_NOT_ALIGHT, K.MAP_NOT_CHANGED, K.NO_RESTING_PLACE, K.ROAD_CLOSED),
        K.LOCALIZATION_MAP_NOT_CHANGED,
        *(K.ORDER_REJECTED, K.RIDE_FAILED),
        *(K.DEPARTURE_MISSED, K.PROMISE_BROKEN, K.TRIPS_UNSERVED, K.SEAT_BUTTON, K.WEBHOOK_DISABLED),
    ]


def test_the_first_who_looks_after_it_is_remembered() -> None:
    once = acknowledged(an_incident(), "ann", NOW)
    assert (once.acknowledged_by, once.acknowledged_at, once.is_open) == ("ann", NOW, True)
    assert acknowledged(once, "bob", NOW) is once


def test_a_closed_incident_names_who_closed_it_and_when() -> None:
    done = closed(acknowledged(an_incident(), "ann", NOW), "bob", NOW)
    assert (done.closed_by, done.closed_at, done.is_open) == ("bob", NOW, False)
    assert done.acknowledged_by == "ann"


def test_a_closed_incident_is_neither_acknowledged_nor_closed_again() -> None:
    done = closed(an_incident(), "ann", NOW)
    for act in (acknowledged, closed):
        with pytest.raises(IncidentClosed, match="ann"):
            act(done, "bob", NOW)
