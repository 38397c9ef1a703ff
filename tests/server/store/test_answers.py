"""Answers under idempotency keys, and pages by position, on SQLite and PostgreSQL."""

from datetime import timedelta

from server.domain.record.answers import KeyedRequest, StoredAnswer
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.record.runs import Run
from server.usecases.ports.views import IncidentPosition
from tests.server.store.conftest import Record
from tests.server.usecases.campus_under_test import MORNING as NOW

CAMPUS = "snow-lion"
REQUEST = KeyedRequest("operator:1", 64 * "a", 64 * "b")
HOUR = timedelta(hours=1)


def test_a_key_is_claimed_once_and_keeps_its_answer(record: Record) -> None:
    assert record.do(lambda uow: uow.answers.claim(REQUEST, NOW)) is None
    record.do(lambda uow: uow.answers.complete(REQUEST, b"\x00sealed\xff"))
    repeated = KeyedRequest(REQUEST.account, REQUEST.key_sha256, 64 * "c")
    known = record.do(lambda uow: uow.answers.claim(repeated, NOW + HOUR))
    assert known == StoredAnswer(CAMPUS, REQUEST, b"\x00sealed\xff", NOW)
    others = KeyedRequest("operator:2", REQUEST.key_sha256, REQUEST.request_sha256)
    assert record.do(lambda uow: uow.answers.claim(others, NOW)) is None


def test_old_answers_are_dropped_and_new_ones_stay(record: Record) -> None:
    newer = KeyedRequest("operator:1", 64 * "d", 64 * "b")
    record.do(lambda uow: (uow.answers.claim(REQUEST, NOW), uow.answers.claim(newer, NOW + HOUR)))
    assert record.do(lambda uow: uow.answers.forget_before(NOW + HOUR)) == 1
    assert record.do(lambda uow: uow.answers.claim(REQUEST, NOW)) is None
    assert record.do(lambda uow: uow.answers.claim(newer, NOW)) is not None


def test_incidents_go_on_after_a_position_among_the_open_and_among_the_closed(record: Record) -> None:
    kinds = (IncidentKind.HELP_CALL, IncidentKind.TAKEOVER)
    made = [
        Incident(CAMPUS, f"i{n}", kinds[n % 2], f"s{n}", "why", NOW + (n // 3) * HOUR, "shuttle-1")
        if n < 6
        else Incident(
            CAMPUS, f"i{n}", kinds[n % 2], f"s{n}", "why", NOW, closed_at=NOW + (n // 3) * HOUR, closed_by="x"
        )
        for n in range(12)
    ]
    record.do(lambda uow: [uow.incidents.add(one) for one in made])
    whole = record.found(lambda uow: uow.views.incidents(include_closed=True))
    assert len(whole) == 12
    for number, one in enumerate(whole):
        after = IncidentPosition(one.priority, one.closed_at, one.opened_at, one.incident_id)
        rest = record.found(lambda uow, after=after: uow.views.incidents(include_closed=True, after=after))  # type: ignore[misc]
        assert rest == whole[number + 1 :]


def test_runs_of_one_moment_go_on_after_a_position(record: Record) -> None:
    runs = [
        Run(CAMPUS, f"shuttle-{vehicle}", f"boot-{boot}", NOW + hour * HOUR, "0.1", "gem", "map")
        for vehicle in (1, 2)
        for boot in (1, 2)
        for hour in (boot,)
    ]
    record.do(lambda uow: [uow.runs.add(run) for run in runs])
    whole = record.found(lambda uow: uow.views.runs())
    assert len(whole) == 4
    for number, run in enumerate(whole):
        after = (run.started_at, run.boot_id, run.vehicle_id)
        assert record.found(lambda uow, after=after: uow.views.runs(after=after)) == whole[number + 1 :]  # type: ignore[misc]
