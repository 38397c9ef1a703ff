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

NOW = datetime(2026, 11, 23, 8, 0, tzinfo=UTC)


def an_incident(kind: IncidentKind = IncidentKind.TAKEOVER) -> Incident:
    return Incident("campus", "incident-1", kind, "shuttle-1", "why", NOW)


def test_every_kind_has_its_own_urgency_and_a_help_call_comes_first() -> None:
    assert set(PRIORITY) == set(IncidentKind)
    assert len(set(PRIORITY.values())) == len(PRIORITY)
    assert min(PRIORITY, key=lambda kind: PRIORITY[kind]) is IncidentKind.HELP_CALL


def test_the_first_who_looks_after_it_is_remembered() -> None:
    once = acknowledged(an_incident(), "ann", NOW)
    assert acknowledged(once, "bob", NOW) is once


def test_a_closed_incident_is_neither_acknowledged_nor_closed_again() -> None:
    done = closed(an_incident(), "ann", NOW)
    for act in (acknowledged, closed):
        with pytest.raises(IncidentClosed, match="ann"):
            act(done, "bob", NOW)
