"""One injection of each kind, in virtual time: every kind does what it must, within the floors."""

import msgspec
import pytest

from benchmarks.drive_by_wire.faults import FaultKind, catalogue
from benchmarks.drive_by_wire.injection import inject
from campusloop.scenes.faulted_drive import Course, winding_course
from vehicle_agent.config import Profile

FLOOR_MS, FLOOR_M = 100.0, 3.5


@pytest.fixture(scope="module")
def courses() -> dict[str, Course]:
    sprung = msgspec.structs.replace(Profile(), fail_action="spring_brake")
    return {profile.fail_action: winding_course(profile, 15.0 / 3.6) for profile in (Profile(), sprung)}


@pytest.mark.parametrize("kind", catalogue(), ids=lambda kind: kind.name)
def test_every_kind_of_fault_ends_as_it_must(kind: FaultKind, courses: dict[str, Course]) -> None:
    for number, course in ((11, courses["coast"]), (22, courses["spring_brake"])):
        row, _ = inject(course, kind, number, seed=5)
        assert row["right"], row
        assert not row["restarts"], row
        if kind.must == "brake":
            assert isinstance(row["latency_ms"], float)
            assert isinstance(row["stop_m"], float)
            assert row["latency_ms"] <= FLOOR_MS, row
            assert row["stop_m"] <= FLOOR_M, row
            assert row["released"] is True, "an operator's resume is all it takes"
