"""What is found of a stretch of time, on both databases."""

from dataclasses import replace
from datetime import timedelta

import msgspec
import pytest

from contract.geometry import Pose2
from contract.wire.messages import Blocked, SectionReleased, VehicleEvent, VisitChanged
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.record.runs import Run, Segment
from server.usecases.ports.past import PastPosition
from server.usecases.record.server_events import record_event
from tests.server.store.conftest import Record
from tests.server.store.test_fleet import SHUTTLE, a_report, add_vehicles
from tests.server.store.test_rides import RIDE
from tests.server.usecases.campus_under_test import MORNING as NOW

SECOND, HOUR = timedelta(seconds=1), timedelta(hours=1)
VISITED = VisitChanged("v1", "gate", "done")
STOOD = Blocked(0, False, 3.0, Pose2(0.0, 0.0, 0.0))


def an_event(sequence: int, after_s: float, body: VehicleEvent) -> RecordedEvent:
    return RecordedEvent("shuttle-1", "boot-2", sequence, 0, ns_of(NOW + after_s * SECOND), body)


def test_positions_of_all_vehicles_are_found_by_when_they_came(record: Record) -> None:
    add_vehicles(record, SHUTTLE, replace(SHUTTLE, vehicle_id="shuttle-2"))
    reports = [
        a_report(t, 10.0 * t, vehicle_id) for t in (0, 1, 2, 3) for vehicle_id in ("shuttle-1", "shuttle-2")
    ]
    record.do(lambda uow: uow.vehicles.save_status(reports))
    found = record.found(lambda uow: uow.past.positions(NOW + SECOND, NOW + 3 * SECOND, 100))
    assert sorted((one.vehicle_id, one.at, one.x_m) for one in found) == [
        ("shuttle-1", NOW + SECOND, 10.0),
        ("shuttle-1", NOW + 2 * SECOND, 20.0),
        ("shuttle-2", NOW + SECOND, 10.0),
        ("shuttle-2", NOW + 2 * SECOND, 20.0),
    ]
    assert found[0] == PastPosition(found[0].vehicle_id, NOW + SECOND, 10.0, 2.0, 0.5, 1.5, "autonomous", 0.8)
    assert len(record.found(lambda uow: uow.past.positions(NOW, NOW + HOUR, 3))) == 3


def test_only_the_asked_kinds_of_events_are_found_in_the_order_in_which_they_came(record: Record) -> None:
    events = [
        an_event(0, 0.0, VISITED),
        an_event(1, 10.0, SectionReleased("s1", 4)),
        an_event(2, 20.0, STOOD),
        an_event(3, 30.0, VISITED),
    ]
    record.do(lambda uow: [uow.events.add(event) for event in events])
    kinds = ("visit_changed", "blocked")
    found = record.found(lambda uow: uow.past.vehicle_events(NOW, NOW + 30 * SECOND, kinds, 100))
    assert found == (events[0], events[2])
    (first,) = record.found(lambda uow: uow.past.vehicle_events(NOW, NOW + HOUR, kinds, 1))
    assert first == events[0]


def test_what_people_ordered_is_found_by_its_name(record: Record) -> None:
    record.do(lambda uow: record_event(uow, "vehicle.hold", "shuttle-1", "ann"))
    record.do(lambda uow: record_event(uow, "token.made", "token-1", "ann"))
    (found,) = record.found(lambda uow: uow.past.server_events(NOW, NOW + HOUR, ("vehicle.hold",), 100))
    assert (found.name, found.subject, found.by) == ("vehicle.hold", "shuttle-1", "ann")


def test_incidents_are_found_by_when_they_were_opened_closed_or_not(record: Record) -> None:
    one = Incident("snow-lion", "i1", IncidentKind.TAKEOVER, "shuttle-1", "", NOW + SECOND)
    other = replace(one, incident_id="i2", subject="shuttle-2", opened_at=NOW, closed_at=NOW + SECOND)
    late = replace(one, incident_id="i3", subject="shuttle-3", opened_at=NOW + HOUR)
    record.do(lambda uow: [uow.incidents.add(incident) for incident in (one, other, late)])
    assert record.found(lambda uow: uow.past.incidents(NOW, NOW + HOUR, 100)) == (other, one)


def test_runs_are_found_that_recorded_something_after_the_beginning(record: Record) -> None:
    def a_run(boot_id: str, started_s: float, *received_s: float) -> Run:
        segments = tuple(
            Segment("snow-lion", "shuttle-1", boot_id, k, f"{boot_id}-{k}", 1, 0, 1, NOW + at_s * SECOND)
            for k, at_s in enumerate(received_s)
        )
        return Run("snow-lion", "shuttle-1", boot_id, NOW + started_s * SECOND, "0.1", "gem", "m", segments)

    runs = [a_run("before", 0.0, 5.0), a_run("during", 1.0, 5.0, 20.0), a_run("after", 60.0, 70.0)]
    empty = a_run("empty", 2.0)

    for run in (*runs, empty):
        record.do(lambda uow, run=run: uow.runs.add(replace(run, segments=())))
        for segment in run.segments:
            record.do(lambda uow, segment=segment: uow.runs.add_segment(segment))
    since, until = NOW + 10 * SECOND, NOW + 60 * SECOND
    assert record.found(lambda uow: uow.past.runs(since, until, 100)) == (runs[1],)


def test_rides_are_found_by_when_they_were_wanted_refused_ones_too(record: Record) -> None:
    early = replace(RIDE, ride_id="r1", ride_code="AAA222", earliest=NOW)
    late = replace(RIDE, ride_id="r2", ride_code="AAA333", earliest=NOW + HOUR)
    record.do(lambda uow: [uow.rides.add(ride) for ride in (late, early)])
    found = record.found(lambda uow: uow.past.wanted_rides(NOW, NOW + HOUR, 10))
    assert [ride.ride_id for ride in found] == ["r1"]


def test_positions_are_counted_by_whole_kilometres_an_hour(record: Record) -> None:
    add_vehicles(record, SHUTTLE)
    speeds_kmh = (0.0, 0.9, 1.0, 9.99, 10.0, -10.4)
    reports = [
        replace(
            a_report(float(k)),
            status=msgspec.structs.replace(a_report(float(k)).status, speed_mps=speed_kmh / 3.6),
        )
        for k, speed_kmh in enumerate(speeds_kmh)
    ]
    record.do(lambda uow: uow.vehicles.save_status(reports))
    found = record.found(lambda uow: uow.past.speeds(NOW, NOW + HOUR))
    assert [(one.from_kmh, one.positions) for one in found] == [(0, 2), (1, 1), (9, 1), (10, 2)]
    assert sum(one.speeds_mps for one in found) == pytest.approx(32.29 / 3.6)
