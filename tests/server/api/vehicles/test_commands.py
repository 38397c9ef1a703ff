"""Commands to one vehicle: the same for the console, REST and a developer's script, and their end is seen."""

import json

import pytest

from contract.wire.messages import CommandDone
from server.api.security.access import Actor
from server.api.sockets.developer_methods import DeveloperMethods, Subscriptions
from server.api.sockets.json_rpc import answer
from server.domain.errors import NoRestingPlaceFree
from server.usecases.planning import plans
from tests.server.api.rides.test_rides import book
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.test_hub import at_rest
from tests.server.fleet.vehicle_key import VehicleKeyPair


def a_shuttle(server: ServerUnderTest, name: str, place: int = 0) -> SpokenVehicle:
    """One that stands ready at a resting place of its own."""
    server.enrol(name, VehicleKeyPair(name).public_base64)
    vehicle = SpokenVehicle(server, name).dial().hello()
    at_rest(server, vehicle, place)
    return vehicle


def call(server: ServerUnderTest, method: str, **params: object) -> dict[str, object]:
    """What a developer's script gets for a request."""
    script = Actor("developer", "developer:token-1", "developer:script")
    methods = DeveloperMethods(server.services, script, Subscriptions()).table()
    request = json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params})
    data = server.run(answer(request, methods, frozenset({"read", "drive"})))
    assert data is not None
    response: dict[str, object] = json.loads(data)
    return response


def last_command(server: ServerUnderTest, vehicle_id: str = "shuttle-1") -> dict[str, object]:
    server.elapse(1.0)
    scene = server.services.feed.board.vehicle(vehicle_id)
    assert scene is not None
    assert scene.command is not None
    facts = server.get(f"/vehicles/{vehicle_id}").json()["last_command"]
    command = scene.command
    assert (facts["command_id"], facts["state"]) == (command.command_id, command.state)
    return {"kind": command.kind, "state": command.state, "detail": command.detail, "by": command.by}


@pytest.mark.parametrize("way", ["rest", "developer"])
def test_a_pause_hands_the_waiting_riders_to_another_shuttle(server: ServerUnderTest, way: str) -> None:
    a_shuttle(server, "shuttle-1")
    ride = book(server, earliest="2026-09-01T10:00:00Z")
    assert ride["vehicle_id"] == "shuttle-1"
    a_shuttle(server, "shuttle-2", place=4)
    headers = server.sign_in()
    if way == "rest":
        assert server.post("/vehicles/shuttle-1/hold", headers=headers).status_code == 202
    else:
        assert "error" not in call(server, "pause", vehicle_id="shuttle-1")
    (after,) = server.get("/rides").json()
    assert after["vehicle_id"] == "shuttle-2"


def test_a_pause_of_a_script_reaches_a_shuttle_whose_rides_cannot_be_replanned(
    server: ServerUnderTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_plan(*_: object) -> None:
        raise NoRestingPlaceFree("every resting place belongs to another shuttle")

    a_shuttle(server, "shuttle-1")
    server.sign_in()
    monkeypatch.setattr(plans, "replan", no_plan)
    assert "error" not in call(server, "pause", vehicle_id="shuttle-1")
    assert last_command(server)["kind"] == "hold"


def test_a_refused_resume_is_shown_with_the_reason_of_the_shuttle(server: ServerUnderTest) -> None:
    vehicle = a_shuttle(server, "shuttle-1")
    server.sign_in()
    response = call(server, "resume", vehicle_id="shuttle-1")
    result = response["result"]
    assert isinstance(result, dict)
    pending = {"kind": "resume", "state": "pending", "detail": "", "by": "developer:script"}
    assert last_command(server) == pending
    vehicle.event(1, CommandDone(result["command_id"], False, "a door is open"))
    assert last_command(server) == pending | {"state": "failed", "detail": "a door is open"}
