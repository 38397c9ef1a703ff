"""Idempotency keys: each command is carried out once, for each actor by itself."""

import json
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import httpx
import pytest
from sqlalchemy import select

from server.store.tables import command_answers
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import answers, identity
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = "6f1d0c1e-2b7a-4f0e-9a34-0d5c2f7be801"
VAN = {"text": "We wait for a van."}


@pytest.fixture
def enrolled(server: ServerUnderTest) -> ServerUnderTest:
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    return server


def bearer(server: ServerUnderTest, *scopes: str, name: str = "script") -> dict[str, str]:
    def work(uow: UnitOfWork) -> str:
        return identity.create_developer_token(uow, name, scopes, 3600.0, "operator").secret  # type: ignore[arg-type]

    return {"Authorization": f"Bearer {server.transact(work)}"}


def announce(
    server: ServerUnderTest, headers: dict[str, str], body: dict[str, str] = VAN, key: str = KEY
) -> httpx.Response:
    path = "/vehicles/shuttle-1/announce"
    return server.post(path, body, headers=headers | {"Idempotency-Key": key})


def commands_sent(server: ServerUnderTest) -> int:
    sent: int = server.transact(lambda uow: len(uow.vehicles.pending_commands("shuttle-1")))
    return sent


def test_a_repeat_gets_the_first_answer_and_does_nothing(enrolled: ServerUnderTest) -> None:
    script = bearer(enrolled, "drive")
    first = announce(enrolled, script)
    assert first.status_code == 202
    enrolled.elapse(5.0)
    again = announce(enrolled, script)
    assert (again.status_code, again.json()) == (202, first.json())
    assert commands_sent(enrolled) == 1


def test_without_a_key_each_request_is_a_command(enrolled: ServerUnderTest) -> None:
    script = bearer(enrolled, "drive")
    for _ in range(2):
        assert enrolled.post("/vehicles/shuttle-1/announce", VAN, headers=script).status_code == 202
    assert commands_sent(enrolled) == 2


@pytest.mark.parametrize(
    ("method", "path", "body"),
    [
        ("POST", "/vehicles/shuttle-1/announce", {"text": "Another text."}),
        ("POST", "/vehicles/shuttle-1/announce?loud=1", VAN),
        ("POST", "/vehicles/shuttle-1/resume", None),
        ("DELETE", "/closures/closure-1", None),
    ],
)
def test_the_same_key_with_another_request_is_refused(
    enrolled: ServerUnderTest, method: str, path: str, body: object
) -> None:
    script = bearer(enrolled, "drive") | {"Idempotency-Key": KEY}
    assert announce(enrolled, script).status_code == 202
    other = enrolled.request(method, path, json=body, headers=script)
    assert (other.status_code, other.json()["code"]) == (409, "idempotency_mismatch")
    assert commands_sent(enrolled) == 1


def test_keys_of_different_actors_do_not_meet(enrolled: ServerUnderTest) -> None:
    actors = [bearer(enrolled, "drive", name="a"), bearer(enrolled, "drive", name="b"), enrolled.sign_in()]
    commands = {announce(enrolled, headers).json()["command_id"] for headers in actors}
    assert len(commands) == 3


def test_a_refusal_is_not_kept_and_a_repeat_tries_again(server: ServerUnderTest) -> None:
    script = bearer(server, "drive")
    assert announce(server, script).json()["code"] == "vehicle_unknown"
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    assert announce(server, script).status_code == 202


def test_a_key_can_be_used_again_after_a_day(enrolled: ServerUnderTest) -> None:
    script = bearer(enrolled, "drive")
    assert announce(enrolled, script).status_code == 202

    def much_later(uow: UnitOfWork) -> int:
        uow.now += answers.KEPT + timedelta(seconds=1)
        return answers.forget_old_answers(uow)

    assert enrolled.transact(much_later) == 1
    assert announce(enrolled, script, {"text": "Another text."}).status_code == 202


def test_a_dry_run_with_a_key_leaves_the_key_free(enrolled: ServerUnderTest) -> None:
    script = bearer(enrolled, "drive") | {"Idempotency-Key": KEY}
    tried = enrolled.post("/vehicles/shuttle-1/send?stop_id=C6&dry_run=true", headers=script)
    assert tried.json()["code"] == "vehicle_not_placed"
    assert announce(enrolled, script).status_code == 202


@pytest.mark.parametrize("path", ["/cancel", "/help"])
def test_a_passenger_who_repeats_gets_the_first_answer(server: ServerUnderTest, path: str) -> None:
    ride = server.post("/rides", {"from_stop": "NN7", "to_stop": "C6"}).json()
    assert ride["state"] == "refused"
    url, body = f"/rides/{ride['token']}{path}", {"text": "help"} if path == "/help" else None
    headers = {"Idempotency-Key": KEY, "X-Request-Id": "same-in-both"}
    first = server.post(url, body, headers=headers)
    again = server.post(url, body, headers=headers)
    assert (again.status_code, again.json()) == (first.status_code, first.json())


def test_a_void_answer_is_repeated_too(server: ServerUnderTest) -> None:
    script = bearer(server, "drive")
    closed = server.post("/closures", {"lane_ids": ["east-4"]}, headers=script).json()
    for _ in range(2):
        path, headers = f"/closures/{closed['closure_id']}", script | {"Idempotency-Key": KEY}
        assert server.request("DELETE", path, headers=headers).status_code == 204


def test_neither_key_nor_answer_can_be_read_in_the_database(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path)
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    command = announce(server, bearer(server, "drive")).json()

    def rows(uow: Any) -> list[tuple[object, ...]]:
        return [tuple(row) for row in uow.answers._connection.execute(select(command_answers))]

    (stored,) = server.transact(rows)
    text = repr(stored)
    assert stored[4]
    for secret in (KEY, command["command_id"], "announce", VAN["text"]):
        assert secret not in text
    server.close()


def test_bookings_of_developers_are_theirs_and_their_keys_too(server: ServerUnderTest) -> None:
    wish = {"from_stop": "NN7", "to_stop": "C6"}
    first, other = bearer(server, "drive", name="a"), bearer(server, "drive", name="b")
    rides = [
        server.post("/rides", wish, headers=headers | {"Idempotency-Key": KEY}).json()["ride_id"]
        for headers in (first, first, other, {})
    ]
    assert rides[0] == rides[1]
    assert len(set(rides)) == 3
    reader = bearer(server, "read")
    sources = {ride_id: server.get(f"/rides/id/{ride_id}", headers=reader).json() for ride_id in rides}
    assert [sources[ride_id]["source"] for ride_id in rides] == [*["developer"] * 3, "passenger"]
    assert {ride["boarding_code"] for ride in sources.values()} == {""}


def test_an_intervention_is_carried_out_once_and_its_effects_are_repeated(enrolled: ServerUnderTest) -> None:
    headers = enrolled.sign_in() | {"Idempotency-Key": KEY}
    path = "/vehicles/shuttle-1/hold?for_s=600"
    first, again = (enrolled.post(path, headers=headers) for _ in range(2))
    assert json.loads(first.text) == json.loads(again.text)
    assert commands_sent(enrolled) == 1


def test_a_failure_after_the_command_frees_the_key(enrolled: ServerUnderTest) -> None:
    request = answers.KeyedRequest("operator:1", "key", "request")

    def breaks(_: UnitOfWork) -> None:
        raise RuntimeError("the disk is full")

    with pytest.raises(RuntimeError):
        enrolled.transact(lambda uow: answers.answer_once(uow, request, breaks, lambda _: b"sealed"))
    kept = enrolled.transact(lambda uow: answers.answer_once(uow, request, lambda _: 7, lambda _: b"sealed"))
    assert kept == 7
    with pytest.raises(answers.AnsweredBefore):
        enrolled.transact(lambda uow: answers.answer_once(uow, request, breaks, lambda _: b"sealed"))
    other = replace(request, request_sha256="other")
    with pytest.raises(answers.IdempotencyMismatch):
        enrolled.transact(lambda uow: answers.answer_once(uow, other, breaks, lambda _: b"sealed"))
