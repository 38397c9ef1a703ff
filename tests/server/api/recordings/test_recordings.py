"""Operators mark what a vehicle records, and start and stop recordings: in reach, out of reach, too old."""

import hashlib
from pathlib import Path
from typing import Any

import httpx
import msgspec
import pytest

from contract.runlog.records import MARK_TOPIC, recording_mark
from contract.wire.messages import Command, CommandDone, EventReport
from contract.wire.upload import SIGNATURE_HEADER, segment_path, signed_segment
from server.domain.record.identity import Role
from tests.contract.runlog.test_segment import UTC_OFFSET_NS, write_segment
from tests.server.api.security.test_roles import headers_of
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = VehicleKeyPair("shuttle-1")
NOTE = {"note": "Braked for a shadow?"}
RUN = "/runs/shuttle-1/boot-1"


@pytest.fixture
def vehicle(server: ServerUnderTest) -> SpokenVehicle:
    server.enrol("shuttle-1", KEY.public_base64)
    return SpokenVehicle(server).dial().hello()


def put(server: ServerUnderTest, path: Path) -> httpx.Response:
    data = path.read_bytes()
    sha256 = hashlib.sha256(data).hexdigest()
    headers = {"Vehicle-Id": "shuttle-1", SIGNATURE_HEADER: KEY.sign(signed_segment("shuttle-1", sha256))}
    return server.run(server.client.put(segment_path(sha256), content=data, headers=headers))


def command_state(server: ServerUnderTest, command_id: str) -> tuple[str, str]:
    command = server.transact(lambda uow: uow.vehicles.command(command_id))
    return command.state, command.detail


def heard(vehicle: SpokenVehicle) -> list[tuple[str, str]]:
    return [(command.kind, command.text) for command in vehicle.all(Command)]


def recording_of(server: ServerUnderTest) -> dict[str, Any]:
    (one,) = server.get("/recordings", params={"vehicle_id": "shuttle-1"}).json()
    return dict(one)


def test_a_mark_reaches_the_vehicle_with_its_moment_and_its_answer_ends_it(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    before_ns = server.services.clock.now().timestamp() * 1e9
    answer = server.post("/vehicles/shuttle-1/marks", NOTE, headers=server.sign_in())
    assert (answer.status_code, answer.json()["state"]) == (202, "pending")
    server.elapse(0.2)
    (command,) = vehicle.all(Command)
    assert (command.kind, command.text) == ("mark", NOTE["note"])
    assert 0 <= command.made_ns - before_ns < 1e9
    vehicle.event(0, CommandDone(command.command_id, True))
    assert command_state(server, command.command_id) == ("done", "")
    said = server.transact(lambda uow: uow.audit.newest(1))
    assert (said[0].action.action, said[0].action.command_id) == ("mark_recording", command.command_id)


def test_a_vehicle_out_of_reach_gets_the_mark_when_it_is_back_and_until_then_it_is_pending(
    server: ServerUnderTest,
) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    mark = server.post("/vehicles/shuttle-1/marks", NOTE, headers=server.sign_in()).json()
    server.elapse(3600.0)
    assert command_state(server, mark["command_id"])[0] == "pending"
    vehicle = SpokenVehicle(server).dial().hello()
    server.elapse(0.5)
    (command,) = vehicle.all(Command)
    # It was marked an hour ago, and that is what the vehicle writes.
    assert server.services.clock.now().timestamp() - command.made_ns * 1e-9 > 3599.0


def test_an_agent_that_is_too_old_is_not_sent_what_it_cannot_read(server: ServerUnderTest) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    vehicle = SpokenVehicle(server).dial().hello(understands=())
    headers = server.sign_in()
    mark = server.post("/vehicles/shuttle-1/marks", NOTE, headers=headers).json()
    server.post("/vehicles/shuttle-1/recordings", {"name": "Rain"}, headers=headers)
    server.elapse(1.0)
    assert heard(vehicle) == []
    assert vehicle.goodbye == ""
    state, detail = command_state(server, mark["command_id"])
    assert state == "failed"
    assert "too old" in detail
    refused = recording_of(server)
    assert (refused["state"], refused["detail"]) == ("refused", detail)


def test_a_recording_is_one_at_a_time_and_over_once_it_is_stopped(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    headers = server.sign_in()
    begun = server.post("/vehicles/shuttle-1/recordings", {"name": "Rain"}, headers=headers)
    assert (begun.status_code, begun.json()["state"]) == (202, "waiting")
    again = server.post("/vehicles/shuttle-1/recordings", {"name": "More"}, headers=headers)
    assert (again.status_code, again.json()["code"]) == (409, "recording_under_way")
    server.elapse(0.2)
    vehicle.event(0, CommandDone(vehicle.last(Command).command_id, True))
    assert recording_of(server)["state"] == "running"
    stop = f"/vehicles/shuttle-1/recordings/{begun.json()['recording_id']}/stop"
    assert server.post(stop, headers=headers).json()["state"] == "stopping"
    late = server.post(stop, headers=headers)
    assert (late.status_code, late.json()["code"]) == (409, "recording_over")
    server.elapse(0.2)
    vehicle.event(1, CommandDone(vehicle.last(Command).command_id, True))
    assert recording_of(server)["state"] == "ended"
    assert heard(vehicle) == [("start_recording", "Rain"), ("stop_recording", "Rain")]
    unknown = server.post("/vehicles/shuttle-1/recordings/command-999/stop", headers=headers)
    assert (unknown.status_code, unknown.json()["code"]) == (404, "recording_unknown")


def test_a_recording_is_kept_when_the_file_in_which_it_ends_has_come(
    server: ServerUnderTest, tmp_path: Path
) -> None:
    """The process that talks with the server counts its own starts; files have the tick's."""
    server.enrol("shuttle-1", KEY.public_base64)
    vehicle = SpokenVehicle(server, boot_id="link-7").dial().hello()
    headers = server.sign_in()
    begun = server.post("/vehicles/shuttle-1/recordings", {"name": "Rain"}, headers=headers).json()
    server.elapse(0.2)
    start = vehicle.last(Command)
    vehicle.event(0, CommandDone(start.command_id, True))
    server.post(f"/vehicles/shuttle-1/recordings/{begun['recording_id']}/stop", headers=headers)
    server.elapse(0.2)
    stop = vehicle.last(Command)
    vehicle.event(1, CommandDone(stop.command_id, True))
    assert (recording_of(server)["state"], recording_of(server)["boot_id"]) == ("ended", "")
    writer = write_segment(tmp_path / "0.mcap", 100, close=False)
    for command, stamp_ns in ((start, 20_000_000), (stop, 1_990_000_000)):
        mark = recording_mark(command.made_ns, "Rain", command.kind, command.command_id)  # type: ignore[arg-type]
        writer.add(MARK_TOPIC, stamp_ns, msgspec.json.encode(mark))
    writer.close()
    assert put(server, tmp_path / "0.mcap").status_code == 201
    kept = recording_of(server)
    assert (kept["state"], kept["boot_id"], [one["number"] for one in kept["segments"]]) == (
        "kept",
        "boot-1",
        [0],
    )


def test_a_file_before_a_recording_is_none_of_its_files(
    server: ServerUnderTest, vehicle: SpokenVehicle, tmp_path: Path
) -> None:
    server.post("/vehicles/shuttle-1/recordings", {"name": "Rain"}, headers=server.sign_in())
    server.elapse(0.2)
    vehicle.say(
        EventReport(vehicle.epoch, "boot-1", 0, 10**12, CommandDone(vehicle.last(Command).command_id, True))
    )
    write_segment(tmp_path / "0.mcap", 100)
    assert put(server, tmp_path / "0.mcap").status_code == 201
    assert (recording_of(server)["state"], recording_of(server)["segments"]) == ("running", [])


def test_the_marks_of_a_run_are_those_of_its_files_and_those_that_only_the_server_has(
    server: ServerUnderTest, vehicle: SpokenVehicle, tmp_path: Path
) -> None:
    headers = server.sign_in()
    server.post("/vehicles/shuttle-1/marks", NOTE, headers=headers)
    server.elapse(0.2)
    known = vehicle.last(Command)
    server.post("/vehicles/shuttle-1/marks", {"note": "Not there yet"}, headers=headers)
    server.elapse(1.0)
    # Recorded at this time by the server's clock.
    offset_ns = known.made_ns - 1_000_000_000
    writer = write_segment(tmp_path / "0.mcap", 500, close=False, utc_offset_ns=offset_ns)
    mark = recording_mark(known.made_ns, known.text, "mark", known.command_id)
    foreign = recording_mark(UTC_OFFSET_NS, "From another server", "start_recording", "command-77")
    for one in (mark, foreign):
        writer.add(MARK_TOPIC, 2_000_000_000, msgspec.json.encode(one))
    writer.close()
    assert put(server, tmp_path / "0.mcap").status_code == 201
    marks = server.get(f"{RUN}/marks").json()
    assert {(one["note"], one["by"], one["state"], one["in_file"]) for one in marks} == {
        ("From another server", "", "done", True),
        (NOTE["note"], "operator", "done", True),
        ("Not there yet", "operator", "pending", False),
    }
    assert [one["at_ms"] for one in marks] == sorted(one["at_ms"] for one in marks)


@pytest.mark.parametrize(("role", "status"), [("viewer", 403), ("dispatcher", 202), ("safety", 202)])
def test_who_may_mark(server: ServerUnderTest, role: Role, status: int) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    headers = headers_of(server, frozenset({role}))
    assert server.post("/vehicles/shuttle-1/marks", NOTE, headers=headers).status_code == status


def test_an_unknown_vehicle_and_an_empty_note_are_refused(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    assert server.post("/vehicles/nobody/marks", NOTE, headers=headers).status_code == 404
    assert server.post("/vehicles/nobody/recordings", {"name": "x"}, headers=headers).status_code == 404
    server.enrol("shuttle-1", KEY.public_base64)
    assert server.post("/vehicles/shuttle-1/marks", {"note": " "}, headers=headers).status_code == 422
