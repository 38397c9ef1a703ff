"""Incidents, runs, identities, leases, calendars, departures and closures: stored and found again."""

from dataclasses import replace
from datetime import date, timedelta

import pytest

from contract.wire.messages import ModeChanged
from server.domain.record.events import RecordedEvent
from server.domain.record.identity import (
    DeveloperToken,
    EnrolmentCode,
    Operator,
    OperatorSession,
    VehicleKey,
)
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.record.runs import Run, Segment
from server.domain.record.webhooks import SigningKey, Webhook
from server.domain.roads.closures import Closure, ClosureState
from server.domain.service.service import Hours, ServiceException, ServicePattern
from server.domain.service.timetable import Call, Departure, DepartureState
from server.usecases.record.server_events import record_event
from tests.server.store.conftest import Record
from tests.server.usecases.campus_under_test import MORNING as NOW

SECOND, HOUR = timedelta(seconds=1), timedelta(hours=1)
CAMPUS = "snow-lion"
MONDAY = date(2026, 11, 23)


def an_incident(number: int, kind: IncidentKind = IncidentKind.TAKEOVER, **more: object) -> Incident:
    made = Incident(
        CAMPUS, f"i{number}", kind, f"shuttle-{number}", "why", NOW + number * SECOND, "shuttle-1"
    )
    return replace(made, **more)  # type: ignore[arg-type]


def test_open_incidents_are_listed_by_urgency_and_age_and_closed_ones_newest_first(record: Record) -> None:
    late_help = an_incident(5, IncidentKind.HELP_CALL, ride_id="ride-1", vehicle_id=None)
    old, new = an_incident(1), an_incident(2)
    closed = [an_incident(n, closed_at=NOW + n * HOUR, closed_by="ann") for n in (3, 4)]
    record.do(lambda uow: [uow.incidents.add(i) for i in (new, *closed, late_help, old)])
    assert record.found(lambda uow: uow.incidents.all_open()) == (late_help, old, new)
    everything = record.found(lambda uow: uow.views.incidents(include_closed=True))
    assert everything == (late_help, old, new, closed[1], closed[0])
    assert record.found(lambda uow: uow.views.incidents(limit=1)) == (late_help,)


def test_one_cause_has_one_open_incident(record: Record) -> None:
    incident = an_incident(1)
    record.do(lambda uow: uow.incidents.add(incident))
    find = lambda uow: uow.incidents.open_about(IncidentKind.TAKEOVER, "shuttle-1")  # noqa: E731
    assert record.found(find) == incident
    assert record.found(lambda uow: uow.incidents.open_about(IncidentKind.HELP_CALL, "shuttle-1")) is None
    assert record.found(lambda uow: uow.incidents.open_about(IncidentKind.TAKEOVER, "shuttle-2")) is None
    closed = replace(
        incident, acknowledged_at=NOW, acknowledged_by="ann", closed_at=NOW + HOUR, closed_by="bob"
    )
    record.do(lambda uow: uow.incidents.save(closed))
    assert record.found(find) is None
    assert record.found(lambda uow: uow.incidents.get("i1")) == closed
    assert record.found(lambda uow: uow.incidents.get("i2")) is None


def test_runs_are_listed_newest_first_with_their_segments_in_order(record: Record) -> None:
    runs = [Run(CAMPUS, "shuttle-1", f"boot-{n}", NOW + n * HOUR, "0.1", "gem", "map") for n in range(2)]
    segments = [
        Segment(CAMPUS, "shuttle-1", "boot-1", n, f"{n:064d}", 1000 + n, n * 10, n * 10 + 9, NOW)
        for n in range(3)
    ]
    record.do(lambda uow: [uow.runs.add(run) for run in runs])
    record.do(lambda uow: [uow.runs.add_segment(segment) for segment in reversed(segments)])
    whole = replace(runs[1], segments=tuple(segments))
    assert record.found(lambda uow: uow.views.runs()) == (whole, runs[0])
    assert record.found(lambda uow: uow.views.runs(limit=1)) == (whole,)
    assert record.found(lambda uow: uow.views.runs("shuttle-2")) == ()
    assert record.found(lambda uow: uow.views.run("shuttle-1", "boot-1")) == whole
    assert record.found(lambda uow: uow.views.run("shuttle-1", "boot-9")) is None
    assert record.found(lambda uow: uow.runs.segment(segments[1].sha256)) == segments[1]
    assert record.found(lambda uow: uow.runs.segment("0" * 63)) is None


def test_operators_their_sessions_and_keys_are_found_by_what_is_shown(record: Record) -> None:
    operator = Operator(CAMPUS, "op-1", "ann", "argon2id$...", NOW, frozenset({"admin", "viewer"}))
    sessions = [OperatorSession(CAMPUS, f"{n:064d}", "op-1", NOW, NOW + n * HOUR) for n in range(3)]
    key = VehicleKey(CAMPUS, "shuttle-1", "base64", NOW)
    code = EnrolmentCode(CAMPUS, "a" * 64, "shuttle-1", "ann", NOW + HOUR)
    record.do(lambda uow: (uow.identity.save_operator(operator), uow.identity.save_vehicle_key(key)))
    record.do(lambda uow: [uow.identity.add_operator_session(session) for session in sessions])
    record.do(lambda uow: uow.identity.save_enrolment_code(code))
    assert record.found(lambda uow: uow.identity.operator("op-1")) == operator
    assert record.found(lambda uow: uow.identity.operator_by_name("ann")) == operator
    assert record.found(lambda uow: uow.identity.operator_by_name("bob")) is None
    assert record.do(lambda uow: uow.identity.forget_sessions_before(NOW + HOUR)) == 1
    assert record.found(lambda uow: uow.identity.operator_session(sessions[0].token_sha256)) is None
    assert record.found(lambda uow: uow.identity.operator_session(sessions[1].token_sha256)) == sessions[1]
    assert record.found(lambda uow: uow.identity.operator_session(sessions[2].token_sha256)) == sessions[2]
    record.do(lambda uow: uow.identity.remove_operator_session(sessions[2].token_sha256))
    assert record.found(lambda uow: uow.identity.operator_session(sessions[2].token_sha256)) is None
    revoked, used = replace(key, revoked_at=NOW + HOUR), replace(code, used_at=NOW)
    record.do(lambda uow: (uow.identity.save_vehicle_key(revoked), uow.identity.save_enrolment_code(used)))
    assert record.found(lambda uow: uow.identity.vehicle_key("shuttle-1")) == revoked
    assert record.found(lambda uow: uow.identity.enrolment_code("a" * 64)) == used
    assert record.found(lambda uow: uow.identity.vehicle_key("shuttle-2")) is None
    assert record.found(lambda uow: uow.identity.enrolment_code("b" * 64)) is None


def test_developer_tokens_keep_their_scopes_and_when_they_were_revoked(record: Record) -> None:
    token = DeveloperToken(
        CAMPUS, "t1", "script", "c" * 64, frozenset({"read", "drive"}), "ann", NOW, NOW + HOUR
    )
    record.do(lambda uow: uow.identity.save_developer_token(token))
    assert record.found(lambda uow: uow.identity.developer_token("c" * 64)) == token
    revoked = replace(token, revoked_at=NOW)
    record.do(lambda uow: uow.identity.save_developer_token(revoked))
    assert record.found(lambda uow: uow.identity.developer_token_by_id("t1")) == revoked
    assert record.found(lambda uow: uow.identity.developer_tokens()) == (revoked,)
    assert record.found(lambda uow: uow.identity.developer_token("d" * 64)) is None


def test_a_lease_has_one_holder_and_every_new_one_a_higher_token(record: Record) -> None:
    take = lambda holder, at_s: record.do(  # noqa: E731
        lambda uow: uow.leases.take("dispatcher", holder, NOW + at_s * SECOND, 10.0)
    )
    assert record.found(lambda uow: uow.leases.token("dispatcher")) == 0
    assert take("one", 0) == 1
    assert take("two", 9) is None
    assert take("one", 9) == 1, "who holds it keeps its token"
    assert take("two", 18) is None
    assert take("two", 19) == 2
    assert take("one", 28) is None
    assert take("two", 40) == 3, "a lease that was lost meanwhile is another one"
    assert record.found(lambda uow: uow.leases.token("dispatcher")) == 3


def test_a_lease_that_was_taken_by_a_clock_set_back_since_is_free(record: Record) -> None:
    """A holder that is gone must not keep the lease for as long as the clock was wrong."""
    take = lambda holder, at_s: record.do(  # noqa: E731
        lambda uow: uow.leases.take("dispatcher", holder, NOW + at_s * SECOND, 10.0)
    )
    assert take("gone", 3600) == 1
    assert take("next", 0) == 2
    assert take("gone", 1) is None


def test_patterns_are_listed_by_service_and_go_with_their_exceptions(record: Record) -> None:
    term = ServicePattern(CAMPUS, "term", "Term", (0, 1), MONDAY, None, (Hours(1, 2), Hours(3, 4)))
    exam = ServicePattern(CAMPUS, "exam", "Exams", (5,))
    exceptions = [
        ServiceException(CAMPUS, MONDAY + timedelta(days=2), "term", True, "extra", "ann"),
        ServiceException(CAMPUS, MONDAY, "term", False),
        ServiceException(CAMPUS, MONDAY, "", False, "Founding Day"),
        ServiceException(CAMPUS, MONDAY, "exam", True),
    ]
    record.do(lambda uow: [uow.service.save_pattern(pattern) for pattern in (term, exam)])
    record.do(lambda uow: [uow.service.save_exception(exception) for exception in exceptions])
    record.do(lambda uow: uow.service.remove_pattern("daily"))
    assert record.found(lambda uow: uow.service.patterns()) == (exam, term)
    assert record.found(lambda uow: uow.service.pattern("term")) == term
    listed = record.found(lambda uow: uow.service.exceptions())
    assert listed == (exceptions[2], exceptions[3], exceptions[1], exceptions[0])
    since = record.found(lambda uow: uow.service.exceptions(MONDAY + timedelta(days=1)))
    assert since == (exceptions[0],)
    record.do(lambda uow: uow.service.remove_pattern("term"))
    assert record.found(lambda uow: uow.service.patterns()) == (exam,)
    assert record.found(lambda uow: uow.service.exceptions()) == (exceptions[2], exceptions[3])
    assert record.do(lambda uow: uow.service.remove_exception(MONDAY, ""))
    assert not record.do(lambda uow: uow.service.remove_exception(MONDAY, ""))


def test_unfinished_departures_are_listed_by_their_first_call(record: Record) -> None:
    calls = tuple(Call(stop, NOW + n * HOUR) for n, stop in enumerate(("C6", "NN20")))
    later = Departure(
        CAMPUS, "b@2026-11-23", "b", tuple(replace(c, leave_at=c.leave_at + HOUR) for c in calls)
    )
    sooner = Departure(CAMPUS, "a@2026-11-23", "a", calls, DepartureState.ASSIGNED, "shuttle-1")
    gone = [
        Departure(CAMPUS, f"{state}@2026-11-23", "c", calls, state, reason="why")
        for state in (DepartureState.DONE, DepartureState.MISSED, DepartureState.WITHDRAWN)
    ]
    record.do(lambda uow: [uow.departures.add(departure) for departure in (later, *gone, sooner)])
    assert record.found(lambda uow: uow.departures.unfinished()) == (sooner, later)
    assert record.found(lambda uow: uow.departures.get(gone[0].departure_id)) == gone[0]
    assert record.found(lambda uow: uow.departures.get("x@2026-11-23")) is None
    done = replace(sooner, state=DepartureState.DONE)
    record.do(lambda uow: uow.departures.save(done))
    assert record.found(lambda uow: uow.departures.unfinished()) == (later,)
    assert record.found(lambda uow: uow.views.departures(limit=1)) == (later,)


@pytest.mark.parametrize("state", list(ClosureState))
def test_closures_stand_until_they_are_over(record: Record, state: ClosureState) -> None:
    first = Closure(
        CAMPUS, "c1", ("l",), ("s",), "works", NOW + HOUR, NOW + 2 * HOUR, "ann", NOW, state, "bob"
    )
    second = Closure(CAMPUS, "c2", (), ("s",), "", NOW, None, "ann", NOW)
    record.do(lambda uow: (uow.closures.add(first), uow.closures.add(second)))
    standing = (second,) if state is ClosureState.OVER else (second, first)
    assert record.found(lambda uow: uow.closures.standing()) == standing
    assert record.found(lambda uow: uow.closures.get("c1")) == first
    assert record.found(lambda uow: uow.closures.get("c3")) is None


def test_events_of_one_vehicle_or_of_all_are_listed_newest_first(record: Record) -> None:
    told = [
        RecordedEvent(vehicle_id, "boot-1", sequence, received_ns, received_ns, ModeChanged("held"))
        for vehicle_id, sequence, received_ns in (
            ("shuttle-1", 0, 1000),
            ("shuttle-2", 0, 2000),
            ("shuttle-1", 1, 3000),
        )
    ]
    record.do(lambda uow: [uow.events.add(event) for event in told])
    assert record.found(lambda uow: uow.views.vehicle_events()) == (told[2], told[1], told[0])
    assert record.found(lambda uow: uow.views.vehicle_events("shuttle-1")) == (told[2], told[0])
    assert record.found(lambda uow: uow.views.vehicle_events("shuttle-3")) == ()
    assert record.found(lambda uow: uow.views.vehicle_events(limit=1)) == (told[2],)


def test_webhooks_are_stored_changed_and_removed(record: Record) -> None:
    new = Webhook(CAMPUS, "w1", "https://a/", ("ride.*",), "o", "ann", NOW, SigningKey("k", 1), 7)
    old = replace(new, webhook_id="w0", created_at=NOW - HOUR)
    full = replace(
        new,
        key=SigningKey("k2", 2),
        old_key=SigningKey("k", 1),
        old_key_until=NOW + HOUR,
        cursor=2**40,
        last_success_at=NOW,
        last_failure_at=NOW,
        last_failure="why",
        failures=3,
        failing_since=NOW,
        next_attempt_at=NOW + HOUR,
        disabled_at=NOW,
        disabled_reason="gone",
    )
    for webhook in (new, old, full):
        record.do(lambda uow, webhook=webhook: uow.webhooks.save(webhook))  # type: ignore[misc]
    assert record.found(lambda uow: uow.webhooks.all()) == (old, full)
    record.do(lambda uow: uow.webhooks.remove("w0"))
    assert record.found(lambda uow: (uow.webhooks.get("w0"), uow.webhooks.get("w1"))) == (None, full)


def test_events_for_webhooks_are_chosen_by_type_and_number(record: Record) -> None:
    first = record.found(lambda uow: uow.webhooks.last_event_number())
    names = ("ride.assigned", "ridexassigned", "vehicle.hold", "vehicle.holder", "ride.completed")
    record.do(lambda uow: [record_event(uow, name, "s", "by") for name in names])

    def chosen(number: int, *types: str, limit: int = 10) -> list[str]:
        found = record.found(lambda uow: uow.webhooks.events_after(number, types, limit))
        assert [n for n, _ in found] == sorted(n for n, _ in found)
        return [event.name for _, event in found]

    assert chosen(first, "ride.*") == ["ride.assigned", "ride.completed"]
    assert chosen(first, "vehicle.hold", "ride.completed") == ["vehicle.hold", "ride.completed"]
    assert chosen(first, "ride.*", limit=1) == ["ride.assigned"]
    assert chosen(first + 1, "ride.*") == ["ride.completed"]
    assert record.found(lambda uow: uow.webhooks.last_event_number()) == first + len(names)
