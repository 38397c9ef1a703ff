"""Hard brakings are told once each, by whom, and the gate's are left to their faults."""

from datetime import UTC, datetime, timedelta

import msgspec
import pytest

from contract.wire.messages import DrivingView, FaultReport
from server.domain.fleet.vehicles import StatusReport
from server.fleet.brakings import BrakingWatch
from tests.contract.runlog.test_segment import a_status
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

BEGIN = datetime(2026, 9, 1, 8, tzinfo=UTC)


def report(at_s: float, accel_mps2: float = -3.0, **changes: object) -> StatusReport:
    status = msgspec.structs.replace(a_status(5), accel_mps2=accel_mps2, **changes)
    return StatusReport("shuttle-1", "boot-1", BEGIN + timedelta(seconds=at_s), status)


def guarding(guard: str) -> dict[str, object]:
    return {"driving": DrivingView(guard=guard)}


@pytest.mark.parametrize(
    ("changes", "by"),
    [
        ({}, "planner"),
        (guarding(""), "planner"),
        (guarding("emergency"), "planner"),
        (guarding("obstacle"), "guard"),
        (guarding("overspeed"), "guard"),
        ({"mode": "manual"}, "driver"),
        (guarding("obstacle") | {"accel_mps2": -0.3}, "guard"),
        (guarding("somebody alongside") | {"accel_mps2": -0.3}, None),
        ({"accel_mps2": -1.9}, None),
        ({"faults": (FaultReport("gate_braking_footprint", "stop", 0),)}, None),
    ],
)
def test_who_brakes(changes: dict[str, object], by: str | None) -> None:
    found = BrakingWatch().note(report(0.0, **changes))  # type: ignore[arg-type]
    assert (None if found is None else found.by) == by


def test_one_braking_is_told_once_however_long_it_takes() -> None:
    watch = BrakingWatch()
    told = [watch.note(report(at_s)) is not None for at_s in (0.0, 0.2, 1.8, 3.6, 6.0, 6.2)]
    assert told == [True, False, False, False, True, False]


def test_a_braking_is_in_the_fleets_past(server: ServerUnderTest) -> None:
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    vehicle = SpokenVehicle(server).dial().hello()
    before_ms = int(server.services.clock.now().timestamp() * 1000)
    vehicle.status(0.0, 0.0, 0.0, accel_mps2=-3.5, driving=DrivingView(guard="obstacle"))
    server.elapse(2.0)
    server.sign_in()
    past = server.get("/replays/fleet", params={"from_ms": before_ms - 1000, "seconds": 60}).json()
    (mark,) = [mark for mark in past["marks"] if mark["kind"] == "braking"]
    assert (mark["vehicle_id"], mark["detail"]) == ("shuttle-1", "braking_by_guard")
    assert 0 <= mark["at_ms"] - before_ms < 1000
