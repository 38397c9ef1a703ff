"""A camera of a vehicle, live: asked for, shown, refused, out of reach, over, and for whom."""

import base64

import pytest

from contract.wire.messages import CameraPicture, Command, CommandDone
from server.usecases.record.commands import send_command
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = VehicleKeyPair("shuttle-1")
CAMERA = "/vehicles/shuttle-1/camera"
JPEG = b"\xff\xd8\xff a street"


@pytest.fixture
def vehicle(server: ServerUnderTest) -> SpokenVehicle:
    server.enrol("shuttle-1", KEY.public_base64)
    return SpokenVehicle(server).dial().hello()


def ask(server: ServerUnderTest, camera: str = "front") -> None:
    answer = server.post(CAMERA, {"camera": camera}, headers=server.sign_in())
    assert answer.status_code == 202, answer.text
    server.elapse(0.2)


def say(vehicle: SpokenVehicle, camera: str, jpeg: bytes = JPEG, **more: str) -> None:
    state = more.pop("state", "recording")
    picture = CameraPicture(vehicle.epoch, 7, camera, state, ("front", "rear"), jpeg=jpeg, **more)  # type: ignore[arg-type]
    vehicle.say(picture)


def test_a_picture_comes_with_its_age_and_who_looks_is_in_the_audit_log(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    ask(server)
    assert (vehicle.last(Command).kind, vehicle.last(Command).text) == ("show_camera", "front")
    first = server.get(CAMERA).json()
    assert (first["request"], first["picture"], first["received_ms"]) == ("pending", None, 0)
    vehicle.event(0, CommandDone(vehicle.last(Command).command_id, True))
    say(vehicle, "front")
    server.elapse(3.0)
    answer = server.get(CAMERA)
    shown = answer.json()
    assert (shown["request"], shown["connected"]) == ("done", True)
    assert base64.b64decode(shown["picture"]["jpeg"]) == JPEG
    assert shown["picture"]["cameras"] == ["front", "rear"]
    assert 3000 <= shown["now_ms"] - shown["received_ms"] < 3600
    assert answer.headers["Cache-Control"] == "no-store"
    action = server.transact(lambda uow: uow.audit.newest(1))[0].action
    assert (action.action, action.subject, action.detail) == ("ask_for_camera", "shuttle-1", "front")


def test_each_camera_has_its_newest_picture_and_without_a_name_the_newest_of_all(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    ask(server)
    say(vehicle, "front")
    server.elapse(1.0)
    say(vehicle, "rear", b"", state="no_picture", detail="unplugged")
    server.elapse(1.0)
    assert server.get(CAMERA, params={"camera": "front"}).json()["picture"]["state"] == "recording"
    newest = server.get(CAMERA).json()["picture"]
    assert (newest["camera"], newest["state"], newest["detail"]) == ("rear", "no_picture", "unplugged")
    assert server.get(CAMERA, params={"camera": "roof"}).json()["picture"] is None
    assert server.get(CAMERA, params={"camera": "../x"}).status_code == 422


def test_a_picture_is_gone_a_minute_after_the_request(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    ask(server)
    say(vehicle, "front")
    server.elapse(61.0)
    over = server.get(CAMERA).json()
    assert (over["request"], over["picture"]) == ("", None)


def test_a_vehicle_out_of_reach_is_not_asked_and_a_late_request_is_not_sent(server: ServerUnderTest) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    headers = server.sign_in()
    answer = server.post(CAMERA, {}, headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (409, "vehicle_not_connected")
    server.transact(lambda uow: send_command(uow, "shuttle-1", "show_camera", "operator", "front"))
    server.elapse(30.0)
    vehicle = SpokenVehicle(server).dial().hello()
    server.elapse(1.0)
    assert vehicle.all(Command) == []
    assert "not in reach in time" in server.get(CAMERA).json()["detail"]
    assert server.get("/vehicles/shuttle-9/camera").status_code == 404


def test_who_only_looks_sees_no_camera(server: ServerUnderTest, vehicle: SpokenVehicle) -> None:
    assert server.get(CAMERA).status_code == 401
    headers = server.sign_in()
    made = server.post("/operators", {"name": "viewer", "roles": ["viewer"]}, headers=headers).json()
    server.client.cookies.clear()
    opened = server.post("/session", {"name": "viewer", "password": made["initial_password"]}).json()
    chosen = {"password": made["initial_password"], "new_password": "correct horse battery 2"}
    headers = {"X-CSRF-Token": opened["csrf_token"]}
    assert server.post("/session/password", chosen, headers=headers).is_success
    asked = server.post(CAMERA, {}, headers=headers)
    assert {asked.status_code, server.get(CAMERA).status_code} == {403}
    assert vehicle.all(Command) == []


def test_a_picture_that_is_too_large_is_no_message(server: ServerUnderTest, vehicle: SpokenVehicle) -> None:
    ask(server)
    say(vehicle, "front", b"\xff" * 100_001)
    server.elapse(0.2)
    assert server.get(CAMERA).json()["picture"] is None
