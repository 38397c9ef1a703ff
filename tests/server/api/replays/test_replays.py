"""The fleet's past over REST."""

from datetime import timedelta

import msgspec
import pytest

from contract.geometry import Pose2
from server.api.replays.routes import Cuts
from server.domain.fleet.vehicles import StatusReport
from server.domain.instants import ms_of
from server.live.past import FleetPast, FleetPositions
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.api.server_under_test import START, ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair
from tests.server.store.test_fleet import STATUS

FROM_MS = ms_of(START)


def drove(server: ServerUnderTest, seconds: int) -> None:
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)

    def work(uow: UnitOfWork) -> None:
        uow.vehicles.save_status(
            [
                StatusReport(
                    "shuttle-1",
                    "boot-1",
                    START + timedelta(seconds=k),
                    msgspec.structs.replace(STATUS, pose_map=Pose2(float(k), 0.0, 0.0), stamp_ns=k),
                )
                for k in range(seconds)
            ]
        )

    server.transact(work)


def test_only_who_may_read_the_console_sees_the_past(server: ServerUnderTest) -> None:
    for path in ("/replays/fleet", "/replays/positions"):
        assert server.get(path, params={"from_ms": FROM_MS}).status_code == 401


def test_an_hour_is_read_in_parts_that_fit_together(server: ServerUnderTest) -> None:
    drove(server, 300)
    server.sign_in()
    at_ms: list[int] = []
    from_ms = FROM_MS
    for _ in range(3):
        answer = server.get(
            "/replays/positions", params={"from_ms": from_ms, "seconds": 100, "step_ms": 5000}
        )
        assert answer.status_code == 200, answer.text
        found = msgspec.json.decode(answer.content, type=FleetPositions)
        at_ms += found.tracks[0].at_ms
        from_ms = found.to_ms
    assert at_ms == [FROM_MS + 5000 * k for k in range(60)]


def test_a_day_names_the_fleet_and_what_people_did_with_it(server: ServerUnderTest) -> None:
    drove(server, 5)
    headers = server.sign_in()
    assert server.post("/vehicles/shuttle-1/hold", {"reason": "test"}, headers=headers).is_success
    answer = server.get("/replays/fleet", params={"from_ms": FROM_MS})
    assert answer.status_code == 200, answer.text
    found = msgspec.json.decode(answer.content, type=FleetPast)
    assert [vehicle.vehicle_id for vehicle in found.vehicles] == ["shuttle-1"]
    assert ("intervention", "vehicle.hold", "shuttle-1") in [
        (mark.kind, mark.detail, mark.vehicle_id) for mark in found.marks
    ]
    assert not found.is_cut


def test_times_that_are_none_are_refused(server: ServerUnderTest) -> None:
    server.sign_in()
    for wrong in ({"from_ms": -1}, {"from_ms": 1 << 60}, {"from_ms": 0, "seconds": 10**6}, {}):
        assert server.get("/replays/fleet", params=wrong).status_code == 422
    assert server.get("/replays/fleet", params={"from_ms": 1 << 43}).status_code == 200


@pytest.mark.parametrize(("stored", "is_cut"), [(2, False), (3, False), (4, True)])
def test_a_list_that_is_exactly_full_is_whole(stored: int, is_cut: bool) -> None:
    cuts = Cuts()
    assert len(cuts.of(range(stored), 3)) == min(stored, 3)
    assert cuts.is_cut is is_cut
