"""Stored positions and events as browsers get them."""

from datetime import timedelta

from contract.geometry import Pose2
from contract.wire.messages import Blocked, FaultRaised, FaultReport, ModeChanged, VehicleEvent, VisitChanged
from server.domain.instants import ms_of, ns_of
from server.domain.record.events import RecordedEvent, ServerEvent
from server.domain.record.incidents import Incident, IncidentKind
from server.live.past import fleet_positions, marks
from server.usecases.ports.past import PastPosition
from tests.server.usecases.campus_under_test import MORNING

START_MS = ms_of(MORNING)


def at(after_s: float, vehicle_id: str = "shuttle-1") -> PastPosition:
    moment = MORNING + timedelta(seconds=after_s)
    return PastPosition(vehicle_id, moment, after_s, 2.0, 0.1234, 1.239, "autonomous", 0.5)


def an_event(after_s: float, body: VehicleEvent) -> RecordedEvent:
    return RecordedEvent("shuttle-1", "b", 0, 0, ns_of(MORNING + timedelta(seconds=after_s)), body)


def test_each_vehicle_has_at_most_one_position_a_step() -> None:
    found = [at(k / 2, name) for k in range(9) for name in ("shuttle-1", "shuttle-2")]
    positions = fleet_positions(found, START_MS, START_MS + 10_000, 1000, is_cut=False)
    assert [track.vehicle_id for track in positions.tracks] == ["shuttle-1", "shuttle-2"]
    for track in positions.tracks:
        assert track.at_ms == [START_MS + 1000 * k for k in range(5)]
        assert track.x_m == [0.0, 1.0, 2.0, 3.0, 4.0]
        assert (track.yaw_rad[0], track.speed_mps[0]) == (0.123, 1.24)
    assert positions.to_ms == START_MS + 10_000


def test_of_an_answer_that_was_cut_only_the_whole_part_is_told_and_one_can_ask_on() -> None:
    found = [at(k / 2, name) for k in range(9) for name in ("shuttle-1", "shuttle-2")]
    first = fleet_positions(found[:8], START_MS, START_MS + 10_000, 100, is_cut=True)
    assert first.to_ms == START_MS + 1500
    rest = [one for one in found if ms_of(one.at) >= first.to_ms]
    second = fleet_positions(rest, first.to_ms, START_MS + 10_000, 100, is_cut=False)
    for vehicle in (0, 1):
        whole = first.tracks[vehicle].at_ms + second.tracks[vehicle].at_ms
        assert whole == [START_MS + 500 * k for k in range(9)]


def test_more_positions_of_one_millisecond_than_an_answer_holds_do_not_stop_who_asks_on() -> None:
    positions = fleet_positions([at(0.0)] * 3, START_MS, START_MS + 10_000, 100, is_cut=True)
    assert positions.to_ms > positions.from_ms


def test_marks_say_what_happened_and_not_what_is_over() -> None:
    events = [
        an_event(5.0, VisitChanged("v1", "gate", "under_way")),
        an_event(1.0, VisitChanged("v0", "gate", "done")),
        an_event(2.0, ModeChanged("manual")),
        an_event(3.0, ModeChanged("autonomous")),
        an_event(4.0, Blocked(0, False, 3.0, Pose2(0.0, 0.0, 0.0))),
        an_event(4.5, Blocked(0, True, 3.0, Pose2(0.0, 0.0, 0.0))),
        an_event(6.0, FaultRaised(FaultReport("lidar_blind", "stop", 0))),
        an_event(6.5, FaultRaised(FaultReport("gate_braking_footprint", "stop", 0))),
        an_event(7.0, FaultRaised(FaultReport("lidar_blind", "stop", 0), cleared=True)),
    ]
    opened = Incident("c", "i1", IncidentKind.HELP_CALL, "ride-1", "", MORNING, "shuttle-2", "ride-1")
    said = ServerEvent("c", MORNING + timedelta(seconds=8), "vehicle.hold", "shuttle-1", "ann")
    found = marks(events, [opened], [said])
    assert [(mark.at_ms - START_MS, mark.kind) for mark in found] == [
        (0, "incident"),
        (2000, "takeover"),
        (4000, "blocked"),
        (5000, "stop"),
        (6000, "fault"),
        (6500, "braking"),
        (8000, "intervention"),
    ]
    assert (found[0].vehicle_id, found[0].ride_id, found[0].detail) == ("shuttle-2", "ride-1", "help_call")
    assert found[3].stop_id == "gate"
    assert found[4].detail == "lidar_blind"
    assert (found[6].detail, found[6].by) == ("vehicle.hold", "ann")
