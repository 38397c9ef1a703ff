"""Operators ask for scans of an area; vehicles hear of it and send parcels; bad ones are refused."""

import hashlib
from pathlib import Path
from typing import Any

import pytest

from contract.roads.model import Origin
from contract.wire.messages import SCANS_REQUESTED, ScansReported, ScansRequested
from server.domain.record.identity import Role
from tests.server.api.scans.scanning import put_parcel, write_parcel
from tests.server.api.security.test_roles import headers_of
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

# About the first lane of the campus.
AREA = [[-860.0, 150.0], [-820.0, 150.0], [-820.0, 200.0], [-860.0, 200.0]]
FAR = [[5_000.0, 0.0], [5_040.0, 0.0], [5_040.0, 50.0]]
KEY = VehicleKeyPair("shuttle-1")
MIB = 1024 * 1024


@pytest.fixture
def headers(server: ServerUnderTest) -> dict[str, str]:
    server.enrol("shuttle-1", KEY.public_base64)
    return server.sign_in()


def ask(server: ServerUnderTest, headers: dict[str, str], **changes: Any) -> Any:
    body = {"name": "Library", "outline": AREA} | changes
    return server.post("/scan-requests", body, headers=headers)


def one_request(server: ServerUnderTest) -> dict[str, Any]:
    return dict(server.get("/scan-requests").json()[0])


def test_a_vehicle_hears_of_the_area_at_once_and_again_when_it_is_over(
    server: ServerUnderTest, headers: dict[str, str]
) -> None:
    vehicle = SpokenVehicle(server).dial().hello(understands=(SCANS_REQUESTED,))
    assert vehicle.all(ScansRequested) == []
    asked = ask(server, headers, every_m=0.7, bytes_max=3 * MIB, hours=2.0)
    assert (asked.status_code, asked.json()["state"]) == (201, "open")
    server.elapse(0.2)
    (area,) = vehicle.last(ScansRequested).areas
    assert [[corner.x_m, corner.y_m] for corner in area.outline] == AREA
    assert (area.request_id, area.every_m, area.bytes_max) == (asked.json()["request_id"], 0.7, 3 * MIB)
    until_s = area.until_ns * 1e-9 - server.clock.now().timestamp()
    assert until_s == pytest.approx(7200.0, abs=2.0)
    ended = server.post(f"/scan-requests/{area.request_id}/end", headers=headers)
    assert (ended.status_code, ended.json()["state"], ended.json()["ended_by"]) == (
        200,
        "operator",
        "operator",
    )
    server.elapse(0.2)
    assert vehicle.last(ScansRequested).areas == ()
    said = [entry.action.action for entry in server.transact(lambda uow: uow.audit.newest(2))]
    assert said == ["end_scan_request", "request_scans"]


def test_a_vehicle_that_connects_later_hears_of_it_with_its_hello(
    server: ServerUnderTest, headers: dict[str, str]
) -> None:
    ask(server, headers)
    vehicle = SpokenVehicle(server).dial().hello(understands=(SCANS_REQUESTED,))
    server.elapse(0.2)
    assert len(vehicle.last(ScansRequested).areas) == 1


def test_an_old_agent_is_not_told_and_the_operator_is(
    server: ServerUnderTest, headers: dict[str, str]
) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    ask(server, headers)
    server.elapse(0.5)
    assert vehicle.all(ScansRequested) == []
    (found,) = one_request(server)["vehicles"]
    assert (found["vehicle_id"], found["state"]) == ("shuttle-1", "old_agent")


def test_a_request_ends_by_its_time(server: ServerUnderTest, headers: dict[str, str]) -> None:
    asked = ask(server, headers, hours=1.0).json()
    server.elapse(3601.0)
    assert one_request(server)["state"] == "time"
    again = server.post(f"/scan-requests/{asked['request_id']}/end", headers=server.sign_in())
    assert (again.status_code, again.json()["code"]) == (409, "scan_request_over")


@pytest.mark.parametrize(
    ("outline", "code"),
    [
        (FAR, "scan_area_invalid"),
        ([[-860.0, 150.0], [-820.0, 200.0], [-820.0, 150.0], [-860.0, 200.0]], "scan_area_invalid"),
        ([[-850.0, 160.0], [-849.0, 160.0], [-849.0, 161.0]], "scan_area_invalid"),
        ([[-850.0, 160.0], [-849.0, 160.0]], "scan_area_invalid"),
    ],
)
def test_areas_that_no_vehicle_can_scan_are_refused(
    server: ServerUnderTest, headers: dict[str, str], outline: list[list[float]], code: str
) -> None:
    answer = ask(server, headers, outline=outline)
    assert (answer.status_code, answer.json()["code"]) == (400, code)
    assert server.get("/scan-requests").json() == []


@pytest.mark.parametrize(
    "changes",
    [
        {"name": ""},
        {"outline": [[0.0, 1e9], [1.0, 0.0], [1.0, 1.0]]},
        {"outline": [[0.0]]},
        {"outline": [[0.0, 0.0]] * 101},
        {"every_m": 0.0},
        {"bytes_max": 10},
        {"hours": 0.0},
        {"hours": 1e9},
        {"nonsense": 1},
    ],
)
def test_payloads_out_of_bounds_are_refused(
    server: ServerUnderTest, headers: dict[str, str], changes: dict[str, Any]
) -> None:
    assert ask(server, headers, **changes).status_code == 422


def test_two_requests_over_one_area_are_refused_until_the_first_has_ended(
    server: ServerUnderTest, headers: dict[str, str]
) -> None:
    first = ask(server, headers).json()["request_id"]
    for outline in (AREA, []):
        answer = ask(server, headers, outline=outline)
        assert (answer.status_code, answer.json()["code"]) == (409, "scan_area_taken")
        assert "'Library'" in answer.json()["detail"]
    server.post(f"/scan-requests/{first}/end", headers=headers)
    assert ask(server, headers, outline=[]).status_code == 201


def test_parcels_are_taken_once_and_counted(
    server: ServerUnderTest, headers: dict[str, str], tmp_path: Path
) -> None:
    request_id = ask(server, headers).json()["request_id"]
    data = write_parcel(tmp_path / "a.zip", request_id).read_bytes()
    taken = put_parcel(server, data)
    assert (taken.status_code, taken.json()["scans"]) == (201, 2)
    assert put_parcel(server, data).status_code == 200
    put_parcel(server, write_parcel(tmp_path / "b.zip", request_id, number=1, scans=3).read_bytes())
    request = one_request(server)
    (vehicle,) = request["vehicles"]
    assert (request["scans"], vehicle["scans"], vehicle["drives"], vehicle["way_m"]) == (5, 5, 1, 1.0)
    assert vehicle["state"] == "unknown"
    # Also after its end: they were kept before.
    server.post(f"/scan-requests/{request_id}/end", headers=headers)
    later = write_parcel(tmp_path / "c.zip", request_id, number=2).read_bytes()
    assert put_parcel(server, later).status_code == 201


def test_a_request_ends_when_enough_has_come(
    server: ServerUnderTest, headers: dict[str, str], tmp_path: Path
) -> None:
    vehicle = SpokenVehicle(server).dial().hello(understands=(SCANS_REQUESTED,))
    request_id = ask(server, headers, bytes_max=MIB).json()["request_id"]
    server.transact(lambda uow: uow.scans.save_request(_with_bytes_max(uow.scans.request(request_id), 1_000)))
    put_parcel(server, write_parcel(tmp_path / "a.zip", request_id).read_bytes())
    server.elapse(0.3)
    assert one_request(server)["state"] == "size"
    assert vehicle.last(ScansRequested).areas == ()


def _with_bytes_max(request: Any, bytes_max: int) -> Any:
    from dataclasses import replace

    return replace(request, bytes_max=bytes_max)


def test_what_a_vehicle_reports_is_shown(server: ServerUnderTest, headers: dict[str, str]) -> None:
    vehicle = SpokenVehicle(server).dial().hello(understands=(SCANS_REQUESTED,))
    request_id = ask(server, headers).json()["request_id"]
    server.elapse(0.2)
    vehicle.event(0, ScansReported(request_id, "disk_full", 40, 20.5, 1_000, "10 bytes of the disk are free"))
    (found,) = one_request(server)["vehicles"]
    assert (found["state"], found["detail"]) == ("disk_full", "10 bytes of the disk are free")
    assert (found["kept_scans"], found["kept_way_m"], found["kept_bytes"]) == (40, 20.5, 1_000)
    # One that this server does not know changes nothing.
    vehicle.event(1, ScansReported("scans-unknown", "collecting", 1, 1.0, 1))
    assert len(server.get("/scan-requests").json()) == 1


def test_bad_parcels_are_refused_with_their_reason_and_nothing_is_kept(
    server: ServerUnderTest, headers: dict[str, str], tmp_path: Path
) -> None:
    request_id = ask(server, headers).json()["request_id"]

    def refused(data: bytes, vehicle_id: str = "shuttle-1", sha256: str = "") -> tuple[int, str, str]:
        answer = put_parcel(server, data, vehicle_id, sha256)
        return answer.status_code, answer.json()["code"], answer.json()["detail"]

    good = write_parcel(tmp_path / "a.zip", request_id).read_bytes()
    elsewhere = write_parcel(tmp_path / "b.zip", request_id, origin=Origin(31.0, 121.0)).read_bytes()
    campus = write_parcel(tmp_path / "c.zip", request_id, campus_id="another").read_bytes()
    unasked = write_parcel(tmp_path / "d.zip", "scans-none").read_bytes()
    other = write_parcel(tmp_path / "e.zip", request_id, vehicle_id="shuttle-2").read_bytes()
    assert refused(b"")[:2] == (400, "parcel_unreadable")
    assert refused(good[:-20])[:2] == (400, "parcel_unreadable")
    assert refused(good, sha256=64 * "a")[:2] == (400, "parcel_hash_wrong")
    assert refused(elsewhere) == (
        409, "parcel_refused", "the scans lie in another map frame than the road map in force"
    )  # fmt: skip
    assert refused(campus)[:2] == (409, "parcel_refused")
    assert refused(unasked)[:2] == (409, "parcel_refused")
    assert refused(other)[:2] == (409, "parcel_refused")
    assert refused(good, "shuttle-9")[:2] == (404, "key_unknown")
    assert one_request(server)["scans"] == 0
    kept = [path for path in server.settings.var_dir.rglob("*") if path.is_file() and "scans" in path.parts]
    assert kept == []
    # A parcel without a scan cannot be written; one that says so is no parcel.
    assert hashlib.sha256(good).hexdigest()
    assert put_parcel(server, good).status_code == 201


def test_another_vehicle_cannot_answer_for_a_parcel(
    server: ServerUnderTest, headers: dict[str, str], tmp_path: Path
) -> None:
    server.enrol("shuttle-2", VehicleKeyPair("shuttle-2").public_base64)
    request_id = ask(server, server.sign_in()).json()["request_id"]
    data = write_parcel(tmp_path / "a.zip", request_id).read_bytes()
    assert put_parcel(server, data).status_code == 201
    answer = put_parcel(server, data, "shuttle-2")
    assert (answer.status_code, answer.json()["code"]) == (403, "signature_wrong")


@pytest.mark.parametrize(("role", "may"), [("viewer", False), ("dispatcher", True), ("safety", True)])
def test_who_may_ask(server: ServerUnderTest, role: Role, may: bool) -> None:
    headers = headers_of(server, frozenset({role}))
    assert (ask(server, headers).status_code == 201) is may
    assert server.get("/scan-requests", headers=headers).status_code == 200


def test_a_server_that_makes_no_maps_says_so(
    server: ServerUnderTest, headers: dict[str, str], tmp_path: Path
) -> None:
    request_id = ask(server, headers).json()["request_id"]
    put_parcel(server, write_parcel(tmp_path / "a.zip", request_id).read_bytes())
    answer = server.post(f"/scan-requests/{request_id}/maps", headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (409, "scan_maps_unavailable")
