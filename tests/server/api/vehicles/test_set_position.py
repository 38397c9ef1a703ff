"""An operator names the place where a shuttle stands: who may, what the shuttle hears, what it answers."""

import math

import pytest

from contract.geometry import Pose2
from contract.wire.messages import Command, CommandDone
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = VehicleKeyPair("shuttle-1")
POSITION = "/vehicles/shuttle-1/position"
PLACE = {"x_m": 106.25, "y_m": 447.5, "yaw_rad": 4.0}


@pytest.fixture
def vehicle(server: ServerUnderTest) -> SpokenVehicle:
    server.enrol("shuttle-1", KEY.public_base64)
    return SpokenVehicle(server).dial().hello()


def test_the_shuttle_hears_the_place_and_what_came_of_it_is_shown(
    server: ServerUnderTest, vehicle: SpokenVehicle
) -> None:
    answer = server.post(POSITION, json=PLACE, headers=server.sign_in())
    assert answer.status_code == 202
    server.elapse(0.2)
    command = vehicle.last(Command)
    assert command.kind == "set_position"
    assert command.pose_map == Pose2(106.25, 447.5, math.remainder(4.0, math.tau))
    vehicle.event(0, CommandDone(command.command_id, True, "scans agree, 1.2 m from the named place"))
    server.elapse(0.2)
    last = server.get("/vehicles/shuttle-1").json()["last_command"]
    assert (last["kind"], last["state"]) == ("set_position", "done")
    assert last["detail"] == "scans agree, 1.2 m from the named place"
    entry = server.transact(lambda uow: uow.audit.newest(1))[0]
    assert (entry.action.action, entry.action.command_id) == ("set_vehicle_position", command.command_id)


def test_a_moving_shuttle_is_not_told_a_place(server: ServerUnderTest, vehicle: SpokenVehicle) -> None:
    vehicle.status(0.0, 0.0, 0.0, speed_mps=1.5)
    server.elapse(0.5)
    answer = server.post(POSITION, json=PLACE, headers=server.sign_in())
    assert (answer.status_code, answer.json()["code"]) == (409, "vehicle_moves")
    assert vehicle.all(Command) == []


def test_a_shuttle_out_of_reach_is_not_told_a_place(server: ServerUnderTest) -> None:
    server.enrol("shuttle-1", KEY.public_base64)
    answer = server.post(POSITION, json=PLACE, headers=server.sign_in())
    assert (answer.status_code, answer.json()["code"]) == (409, "vehicle_not_connected")
    assert server.post("/vehicles/nobody/position", json=PLACE, headers=server.sign_in()).status_code == 404


@pytest.mark.parametrize("change", [{"x_m": 1e9}, {"yaw_rad": "north"}, {"z_m": 1.0}])
def test_a_place_that_is_none_is_refused(
    server: ServerUnderTest, vehicle: SpokenVehicle, change: dict[str, object]
) -> None:
    assert server.post(POSITION, json=PLACE | change, headers=server.sign_in()).status_code == 422
