"""The audit log at the API: what gets into it, and how it is followed to the vehicle."""

from typing import Any

import pytest

from contract.wire.messages import CommandDone
from server.domain.fleet.vehicles import VehicleCommand
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.api.server_under_test import PASSWORD, ServerUnderTest, snow_lion
from tests.server.fleet.vehicle_key import VehicleKeyPair


@pytest.fixture
def admin(server: ServerUnderTest) -> dict[str, str]:
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    return server.sign_in()


def newest(server: ServerUnderTest, **filters: str) -> dict[str, Any]:
    entry: dict[str, Any] = server.get("/audit", params={"limit": 1, **filters}).json()[0]
    return entry


def test_a_command_is_entered_with_its_person_address_and_id(
    server: ServerUnderTest, admin: dict[str, str]
) -> None:
    made = server.post("/vehicles/shuttle-1/hold", headers=admin).json()
    entry = newest(server)
    known = {name: entry[name] for name in ("kind", "by", "action", "subject", "outcome", "address")}
    assert known == {
        "kind": "operator",
        "by": "operator",
        "action": "hold_vehicle",
        "subject": "shuttle-1",
        "outcome": "done",
        "address": "127.0.0.1",
    }
    assert entry["command_id"] == made["command_id"]


def test_a_repeat_with_the_same_key_is_no_second_entry(
    server: ServerUnderTest, admin: dict[str, str]
) -> None:
    key = {"Idempotency-Key": "the-same-key"}
    for _ in range(2):
        server.post("/vehicles/shuttle-1/hold", headers=admin | key)
    entries = server.get("/audit", params={"action": "hold_vehicle"}).json()
    assert len(entries) == 1


def test_a_refused_command_is_entered_with_its_reason(server: ServerUnderTest, admin: dict[str, str]) -> None:
    server.post("/vehicles/shuttle-9/resume", headers=admin)
    entry = newest(server)
    assert (entry["action"], entry["outcome"]) == ("resume_vehicle", "vehicle_unknown")


def test_sign_ins_and_failures_are_entered_and_no_unknown_name(
    server: ServerUnderTest, admin: dict[str, str]
) -> None:
    for name in ("operator", "my-password-typed-here"):
        server.post("/session", {"name": name, "password": "wrong"})
    unknown, known, signed_in = server.get("/audit", params={"action": "sign_in"}).json()[:3]
    assert (signed_in["by"], signed_in["outcome"]) == ("operator", "done")
    assert (known["kind"], known["by"], known["outcome"]) == ("unknown", "operator", "wrong_credentials")
    assert unknown["by"] == ""


def test_what_a_vehicle_is_told_to_say_is_not_entered(server: ServerUnderTest, admin: dict[str, str]) -> None:
    server.post("/vehicles/shuttle-1/announce", {"text": "Ms Li, please call us"}, headers=admin)
    assert "Li" not in str(newest(server))


def test_an_entry_leads_to_the_answer_of_the_vehicle(server: ServerUnderTest, admin: dict[str, str]) -> None:
    command_id = server.post("/vehicles/shuttle-1/hold", headers=admin).json()["command_id"]
    number = newest(server)["number"]

    def answer(uow: UnitOfWork) -> None:
        command = uow.vehicles.command(command_id)
        assert isinstance(command, VehicleCommand)
        done = CommandDone(command_id, True, "")
        uow.events.add(RecordedEvent("shuttle-1", "boot-1", 0, 81_200, ns_of(uow.now), done))

    server.transact(answer)
    command = server.get(f"/audit/{number}").json()["command"]
    assert (command["boot_id"], command["stamp_ns"]) == ("boot-1", 81_200)


def test_pages_lead_through_all_entries(server: ServerUnderTest, admin: dict[str, str]) -> None:
    for _ in range(3):
        server.post("/vehicles/shuttle-1/hold", headers=admin)
    numbers: list[int] = []
    path = "/audit?limit=2"
    for _ in range(10):
        answer = server.get(path)
        numbers += [entry["number"] for entry in answer.json()]
        if "Link" not in answer.headers:
            break
        path = answer.headers["Link"].split(">")[0].removeprefix("</api/v1")
    assert numbers == list(range(numbers[0], 0, -1))


def test_a_changed_entry_is_found(server: ServerUnderTest, admin: dict[str, str]) -> None:
    assert server.get("/audit/verify").json()["intact"]
    assert PASSWORD not in str(server.get("/audit").json())

    def forge(uow: Any) -> None:
        # A transaction that has not said that it writes is rolled back.
        uow.audit._require_lock()
        uow.audit._connection.exec_driver_sql("UPDATE audit_entries SET made_by = 'eve' WHERE number = 1")

    server.transact(forge)
    found = server.get("/audit/verify").json()
    assert (found["intact"], found["broken_at"]) == (False, 1)


def test_a_ride_booked_with_a_token_is_entered_and_a_passengers_is_not(
    server: ServerUnderTest, admin: dict[str, str]
) -> None:
    token = server.post("/developer-tokens", {"name": "night", "scopes": ["drive"]}, headers=admin).json()
    stops = [stop.stop_id for stop in snow_lion().stops]
    wanted = {"from_stop": stops[0], "to_stop": stops[1], "party": 1}
    server.post("/rides", wanted)
    bearer = {"Authorization": f"Bearer {token['secret']}"}
    booked = server.post("/rides", wanted, headers=bearer).json()
    server.post("/rides", wanted | {"to_stop": "nowhere"}, headers=bearer)
    entries = server.get("/audit", params={"action": "book_ride"}).json()
    known = [(entry["kind"], entry["by"], entry["subject"], entry["outcome"]) for entry in entries]
    assert known == [
        ("developer", "developer:night", "", "stop_unknown"),
        ("developer", "developer:night", booked["ride_id"], "done"),
    ]
