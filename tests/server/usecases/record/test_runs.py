"""Runs and their segments, and the segment that has the moment of an event."""

from dataclasses import replace
from datetime import timedelta

import pytest

from contract.wire.messages import CommandDone
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.domain.record.runs import Segment
from server.usecases.fleet import vehicle_sessions
from server.usecases.fleet.vehicle_sessions import HelloFacts
from server.usecases.record import runs
from tests.server.usecases.campus_under_test import MORNING, CampusUnderTest
from tests.server.usecases.shipped_maps import shipped_map

HELLO = HelloFacts("cart", "link-000001", "1", "gem", "map-0", (), None, 4, 0, run_boot_id="boot-000007")
SEGMENT = Segment("snow-lion", "cart", "boot-000007", 0, "a" * 64, 10, 1_000, 2_000, MORNING)


@pytest.fixture
def campus() -> CampusUnderTest:
    campus = CampusUnderTest(shipped_map("snow-lion"))
    campus.enrol("cart")
    return campus


def test_an_agent_that_records_under_another_boot_has_one_run(campus: CampusUnderTest) -> None:
    campus.do(lambda uow: vehicle_sessions.open_session(uow, HELLO))
    campus.do(lambda uow: runs.add_segment(uow, SEGMENT))
    campus.do(lambda uow: vehicle_sessions.open_session(uow, HELLO))
    found = campus.read(lambda uow: uow.views.runs(limit=10))
    assert [(run.boot_id, len(run.segments)) for run in found] == [("boot-000007", 1)]


def test_an_agent_that_names_no_run_records_under_its_boot(campus: CampusUnderTest) -> None:
    campus.do(lambda uow: vehicle_sessions.open_session(uow, replace(HELLO, run_boot_id="")))
    assert campus.read(lambda uow: uow.runs.get("cart", "link-000001")) is not None


def test_the_segment_of_an_event_is_found_by_the_vehicles_clock(campus: CampusUnderTest) -> None:
    """The computer was started twice: both runs have the same moment of its clock."""
    day_later = replace(
        SEGMENT, boot_id="boot-000008", sha256="b" * 64, received_at=MORNING + timedelta(days=1)
    )
    for segment in (SEGMENT, day_later):
        campus.do(lambda uow, s=segment: runs.add_segment(uow, s))

    def found(stamp_ns: int, days: int) -> str:
        received_ns = ns_of(MORNING + timedelta(days=days, minutes=-5))
        done = CommandDone("c-1", True)
        event = RecordedEvent("cart", "link-000001", 0, stamp_ns, received_ns, done)
        segment = campus.read(lambda uow: runs.segment_with(uow, event))
        return "" if segment is None else segment.boot_id

    assert (found(1_500, 0), found(1_500, 1), found(2_001, 0)) == ("boot-000007", "boot-000008", "")
