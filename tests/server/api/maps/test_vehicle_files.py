"""A map as a vehicle downloads it: by its key only, compressed, and bytes for bytes."""

import httpx
import pytest

from contract.wire.maps import map_path, signed_map_request
from contract.wire.upload import SIGNATURE_HEADER
from server.usecases.fleet import map_drafts
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = VehicleKeyPair("shuttle-1")


@pytest.fixture
def ready(server: ServerUnderTest) -> ServerUnderTest:
    server.enrol("shuttle-1", KEY.public_base64)
    return server


def download(
    server: ServerUnderTest,
    version: str,
    key: VehicleKeyPair = KEY,
    vehicle_id: str = "shuttle-1",
    signed: bytes | None = None,
    coding: str = "gzip",
) -> httpx.Response:
    text = signed_map_request(vehicle_id, version) if signed is None else signed
    headers = {"Vehicle-Id": vehicle_id, SIGNATURE_HEADER: key.sign(text), "Accept-Encoding": coding}
    return server.run(server.client.get(map_path(version), headers=headers))


def test_a_vehicle_gets_the_stored_bytes_compressed(ready: ServerUnderTest) -> None:
    version = ready.get("/campus").json()["map_version"]
    stored = ready.transact(lambda uow: map_drafts.stored_content(uow, version))
    answer = download(ready, version)
    assert answer.status_code == 200, answer.text
    assert answer.headers["Content-Encoding"] == "gzip"
    assert answer.content == stored
    assert int(answer.headers["Content-Length"]) < len(stored) / 2
    plain = download(ready, version, coding="identity")
    assert "Content-Encoding" not in plain.headers
    assert plain.content == stored


def test_only_its_own_key_opens_it_and_a_signature_is_good_for_one_version(ready: ServerUnderTest) -> None:
    version = ready.get("/campus").json()["map_version"]
    stranger = VehicleKeyPair("stranger")
    other = signed_map_request("shuttle-1", "0123456789abcdef")
    for refused in (
        download(ready, version, stranger),
        download(ready, version, signed=other),
        download(ready, version, vehicle_id="shuttle-9"),
    ):
        assert refused.status_code in (401, 403, 404), refused.text
        assert refused.json()["code"] in ("signature_wrong", "key_unknown")


def test_a_version_that_is_not_stored_is_said(ready: ServerUnderTest) -> None:
    answer = download(ready, "0123456789abcdef")
    assert (answer.status_code, answer.json()["code"]) == (404, "map_unknown")
