"""The real method table of /ws/developer: what a token may ask for."""

from typing import Any

import msgspec
import pytest

from server.api.security.access import Actor
from server.api.sockets.developer_methods import DeveloperMethods, Subscriptions
from server.api.sockets.json_rpc import answer
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair

SCRIPT = Actor("developer", "developer:token-1", "developer:script")
# What only shows. Everything else moves a shuttle or keeps it from moving.
READING = {"list_vehicles", "list_stops", "list_rides", "subscribe", "unsubscribe"}
DRIVING = {
    "send_to_stop": {"vehicle_id": "shuttle-1", "stop_id": "C6"},
    "pause": {"vehicle_id": "shuttle-1"},
    "resume": {"vehicle_id": "shuttle-1"},
}


@pytest.fixture
def enrolled(server: ServerUnderTest) -> ServerUnderTest:
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    return server


def ask(server: ServerUnderTest, method: str, params: object, *scopes: str) -> dict[str, Any]:
    table = DeveloperMethods(server.services, SCRIPT, Subscriptions()).table()
    request = msgspec.json.encode({"jsonrpc": "2.0", "id": 1, "method": method, "params": params})
    response = server.run(answer(request, table, frozenset(scopes)))  # type: ignore[arg-type]
    assert response is not None
    decoded: dict[str, Any] = msgspec.json.decode(response)
    return decoded


def commands_sent(server: ServerUnderTest) -> list[str]:
    def work(uow: UnitOfWork) -> list[str]:
        return [command.kind for command in uow.vehicles.pending_commands("shuttle-1")]

    sent: list[str] = server.transact(work)
    return sent


def test_every_method_is_known_here_as_reading_or_driving(server: ServerUnderTest) -> None:
    table = DeveloperMethods(server.services, SCRIPT, Subscriptions()).table()
    assert set(table) == READING | set(DRIVING)


@pytest.mark.parametrize("method", DRIVING)
@pytest.mark.parametrize("scopes", [("read",), (), ("infrastructure",)])
def test_a_token_that_may_not_drive_moves_no_shuttle(
    enrolled: ServerUnderTest, method: str, scopes: tuple[str, ...]
) -> None:
    response = ask(enrolled, method, DRIVING[method], *scopes)
    assert response["error"]["code"] == -32001
    assert commands_sent(enrolled) == []


@pytest.mark.parametrize(("method", "kind"), [("pause", "hold"), ("resume", "resume")])
def test_a_token_that_may_drive_is_obeyed_and_named(
    enrolled: ServerUnderTest, method: str, kind: str
) -> None:
    response = ask(enrolled, method, DRIVING[method], "read", "drive")
    assert response["result"]["state"]
    assert commands_sent(enrolled) == [kind]


@pytest.mark.parametrize("method", sorted(READING))
def test_a_token_that_may_only_drive_is_shown_nothing(enrolled: ServerUnderTest, method: str) -> None:
    params = {"topics": ["rides"]} if "subscribe" in method else {}
    assert ask(enrolled, method, params, "infrastructure")["error"]["code"] == -32001
    assert "result" in ask(enrolled, method, params, "read")


def test_a_script_gets_what_it_subscribed_to_and_no_longer_what_it_gave_up(server: ServerUnderTest) -> None:
    subscriptions = Subscriptions()
    table = DeveloperMethods(server.services, SCRIPT, subscriptions).table()
    for method, topics, left in (
        ("subscribe", ["rides", "events"], ["events", "rides"]),
        ("subscribe", ["rides"], ["events", "rides"]),
        ("unsubscribe", ["rides", "vehicles"], ["events"]),
    ):
        request = msgspec.json.encode(
            {"jsonrpc": "2.0", "id": 1, "method": method, "params": {"topics": topics}}
        )
        response = server.run(answer(request, table, frozenset({"read"})))
        assert response is not None
        assert msgspec.json.decode(response)["result"] == left
        assert sorted(subscriptions.topics) == left


@pytest.mark.parametrize("limit", [1, 2, 3, 500])
def test_pages_of_rides_are_all_rides_newest_first(server: ServerUnderTest, limit: int) -> None:
    booked = []
    for number in range(5):
        booked.append(server.post("/rides", {"from_stop": "NN7", "to_stop": "C6"}).json()["ride_id"])
        server.elapse(1.0 if number % 2 else 0.0)
    whole = ask(server, "list_rides", {}, "read")["result"]
    assert whole["next_cursor"] is None
    assert sorted(ride["ride_id"] for ride in whole["rides"]) == sorted(booked)
    found, cursor = [], None
    for _ in range(6):
        params = {"limit": limit} | ({"cursor": cursor} if cursor else {})
        page = ask(server, "list_rides", params, "read")["result"]
        found += page["rides"]
        cursor = page["next_cursor"]
        if cursor is None:
            break
    assert found == whole["rides"]


@pytest.mark.parametrize("cursor", ["WzFd", "no cursor", "WyJhIiwiYiJd", "Wy0xLCJhIl0"])
def test_a_cursor_of_another_list_is_refused(server: ServerUnderTest, cursor: str) -> None:
    error = ask(server, "list_rides", {"cursor": cursor}, "read")["error"]
    assert error["data"]["code"] == "cursor_invalid"
