"""Who says to be a vehicle and is not: the audit log tells, and nobody can fill it."""

from datetime import UTC, datetime, timedelta
from typing import Any

from contract.wire.messages import Challenge
from server.domain.record.audit import AuditAction, Caller
from server.fleet.refused_hellos import ENTRIES_MAX, EVERY_S, RefusedHellos
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair, a_hello


class StandingClock:
    def __init__(self) -> None:
        self.time = datetime(2026, 9, 1, tzinfo=UTC)

    def now(self) -> datetime:
        return self.time


def entries(server: ServerUnderTest, **filters: str) -> list[dict[str, Any]]:
    server.sign_in()
    found: list[dict[str, Any]] = server.get("/audit", params={"action": "open_session", **filters}).json()
    return found


def said(server: ServerUnderTest, vehicle_id: str, key: str) -> SpokenVehicle:
    vehicle = SpokenVehicle(server, vehicle_id).dial()
    vehicle.say(a_hello(vehicle.last(Challenge).nonce, vehicle_id, key=VehicleKeyPair(key)))
    return vehicle


def test_a_hello_with_another_key_is_entered_with_the_vehicle_it_names(server: ServerUnderTest) -> None:
    assert said(server, "shuttle-1", "a thief").goodbye == "signature_wrong"
    (entry,) = entries(server)
    known = [entry[name] for name in ("kind", "by", "subject", "outcome")]
    assert known == ["unknown", "", "shuttle-1", "signature_wrong"]


def test_a_hello_of_an_unknown_vehicle_is_entered(server: ServerUnderTest) -> None:
    assert said(server, "shuttle-9", "shuttle-9").goodbye == "key_unknown"
    assert [(entry["subject"], entry["outcome"]) for entry in entries(server)] == [
        ("shuttle-9", "key_unknown")
    ]


def test_a_right_hello_is_no_entry(server: ServerUnderTest) -> None:
    assert said(server, "shuttle-1", "shuttle-1").goodbye == ""
    assert entries(server) == []


def test_a_vehicle_that_is_revoked_while_connected_is_no_refused_hello(server: ServerUnderTest) -> None:
    vehicle = said(server, "shuttle-1", "shuttle-1")
    headers = server.sign_in()
    assert server.request("DELETE", "/vehicles/shuttle-1/key", headers=headers).status_code < 300
    server.elapse(3.0)
    assert vehicle.closed
    assert entries(server) == []


def test_the_same_stranger_is_entered_once_a_minute_with_the_count_of_the_others() -> None:
    clock = StandingClock()
    refused = RefusedHellos(clock)
    stranger = Caller("unknown", "", "192.0.2.7")
    first = refused.entry("shuttle-1", "192.0.2.7", "signature_wrong")
    assert first == (stranger, AuditAction("open_session", "shuttle-1", "", "signature_wrong"))
    for _ in range(3):
        clock.time += timedelta(seconds=EVERY_S / 4.0)
        assert refused.entry("shuttle-1", "192.0.2.7", "signature_wrong") is None
    clock.time += timedelta(seconds=EVERY_S / 4.0)
    again = refused.entry("shuttle-1", "192.0.2.7", "signature_wrong")
    assert again is not None
    assert again[1].detail == "3 refused hellos before it are not entered"


def test_names_that_are_made_up_do_not_fill_the_log() -> None:
    clock = StandingClock()
    refused = RefusedHellos(clock)
    found = [refused.entry(f"made-up-{n}", f"192.0.2.{n % 250}", "key_unknown") for n in range(1_000)]
    assert sum(entry is not None for entry in found) == ENTRIES_MAX
    clock.time += timedelta(seconds=EVERY_S)
    assert refused.entry("shuttle-1", "192.0.2.7", "signature_wrong") is not None


def test_a_clock_that_is_set_back_does_not_silence_the_log() -> None:
    clock = StandingClock()
    refused = RefusedHellos(clock)
    refused.entry("shuttle-1", "192.0.2.7", "signature_wrong")
    clock.time -= timedelta(days=1)
    assert refused.entry("shuttle-1", "192.0.2.7", "signature_wrong") is not None
