"""What the developer socket says is what docs/protocol/developer.asyncapi.yaml describes."""

import json
from typing import Any

import jsonschema_rs
import pytest
import yaml

from docs.protocol.build import documents
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.api.sockets.open_socket import OpenSocket, bearer
from tests.server.api.vehicles.test_commands import a_shuttle

DOCUMENT = yaml.safe_load(documents()["developer.asyncapi.yaml"])
REQUESTS: list[tuple[str, object]] = [
    ("subscribe", {"topics": ["vehicles", "rides", "events"]}),
    ("list_vehicles", {}),
    ("list_stops", {}),
    ("list_rides", {"limit": 5}),
    ("list_rides", {"limit": 5, "cursor": "WzE3ODgyNDk2MDAwMDAwMDAsInJpZGUtMSJd"}),
    ("send_to_stop", {"vehicle_id": "shuttle-1", "stop_id": "C6", "dry_run": True}),
    ("send_to_stop", {"vehicle_id": "shuttle-1", "stop_id": "C6", "idempotency_key": "12345678"}),
    ("pause", {"vehicle_id": "shuttle-1"}),
    ("resume", {"vehicle_id": "shuttle-1"}),
    ("unsubscribe", {"topics": ["events"]}),
]
BROKEN: list[tuple[int, bytes]] = [
    (-32700, b"{"),
    (-32600, b"[]"),
    (-32601, b'{"jsonrpc":"2.0","id":1,"method":"fly"}'),
    (-32602, b'{"jsonrpc":"2.0","id":1,"method":"pause"}'),
    (-32000, b'{"jsonrpc":"2.0","id":1,"method":"pause","params":{"vehicle_id":"shuttle-9"}}'),
]


class Script(OpenSocket):
    """A developer's script on /ws/developer."""

    def __init__(self, server: ServerUnderTest, *scopes: str) -> None:
        def work(uow: UnitOfWork) -> str:
            return identity.create_developer_token(uow, "script", scopes, 3600.0, "operator").secret  # type: ignore[arg-type]

        super().__init__(server, "/ws/developer", bearer(server.transact(work)))

    @property
    def answers(self) -> list[dict[str, Any]]:
        return [json.loads(text) for text in self.texts]

    def call(self, method: str, params: object) -> dict[str, Any]:
        self.say(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}), 1.0)
        return next(frame for frame in reversed(self.answers) if "id" in frame)

    def notifications(self, topic: str) -> list[dict[str, Any]]:
        return [frame["params"] for frame in self.answers if frame.get("method") == topic]


def validator(message: str) -> jsonschema_rs.Validator:
    schema = DOCUMENT["components"]["messages"][message]["payload"]
    return jsonschema_rs.validator_for({**schema, "components": DOCUMENT["components"]})


def test_requests_results_and_notifications_are_as_described(server: ServerUnderTest) -> None:
    a_shuttle(server, "shuttle-1")
    script = Script(server, "read", "drive")
    for method, params in REQUESTS:
        validator(method).validate({"jsonrpc": "2.0", "id": 1, "method": method, "params": params})
        answer = script.call(method, params)
        validator(f"{method}_result").validate(answer)
    server.post("/rides", {"from_stop": "NN7", "to_stop": "C6"})
    server.elapse(1.0)
    for topic in ("vehicles", "rides"):
        assert script.notifications(topic), topic
    for frame in script.answers:
        if "method" in frame:
            validator(f"{frame['method']}_notification").validate(frame)
    script.leave()


@pytest.mark.parametrize(("number", "request_"), BROKEN)
def test_errors_are_as_described(server: ServerUnderTest, number: int, request_: bytes) -> None:
    script = Script(server, "read", "drive")
    script.say(request_.decode(), 1.0)
    (answer,) = script.answers
    assert answer["error"]["code"] == number
    validator("error").validate(answer)
    script.leave()


def test_a_missing_scope_is_as_described(server: ServerUnderTest) -> None:
    script = Script(server, "read")
    answer = script.call("pause", {"vehicle_id": "shuttle-1"})
    assert answer["error"]["code"] == -32001
    validator("error").validate(answer)
    script.leave()


def test_a_refused_connection_is_as_described(server: ServerUnderTest) -> None:
    (refusal,) = Script(server, "infrastructure").answers
    assert refusal["params"]["code"] == "scope_missing"
    validator("refused_notification").validate(refusal)


def test_the_description_refuses_what_the_socket_never_says() -> None:
    wrong = [
        {"jsonrpc": "2.0", "id": 1, "result": {"visit_id": 3}},
        {"jsonrpc": "1.0", "id": 1, "result": {"visit_id": "a", "plan_version": 1, "eta": None}},
    ]
    for answer in wrong:
        with pytest.raises(jsonschema_rs.ValidationError):
            validator("send_to_stop_result").validate(answer)


def test_each_topic_begins_with_a_snapshot_and_again_after_another_subscription(
    server: ServerUnderTest,
) -> None:
    a_shuttle(server, "shuttle-1")
    server.elapse(2.0)
    script = Script(server, "read")
    assert script.answers == []
    for _ in range(2):
        script.answers.clear()
        script.call("subscribe", {"topics": ["vehicles"]})
        (first, *_) = script.notifications("vehicles")
        assert first["snapshot"]
        assert [vehicle["vehicle_id"] for vehicle in first["vehicles"]] == ["shuttle-1"]
        assert script.notifications("rides") == []
    script.call("subscribe", {"topics": ["rides"]})
    assert [one["snapshot"] for one in script.notifications("rides")] == [True]
    script.leave()


def test_a_command_with_a_key_is_carried_out_once(server: ServerUnderTest) -> None:
    a_shuttle(server, "shuttle-1")
    script = Script(server, "read", "drive")
    params = {"vehicle_id": "shuttle-1", "idempotency_key": "12345678"}
    first, again = script.call("pause", params), script.call("pause", params)
    assert again["result"] == first["result"]
    other = script.call("resume", params)
    assert other["error"]["data"]["code"] == "idempotency_mismatch"
    script.leave()
