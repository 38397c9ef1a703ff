"""Old scans and decided maps are deleted with their bytes; what became of them can still be read."""

import hashlib
from pathlib import Path

import pytest

from server.api.runs.offload import InlineOffload
from server.domain.rules import FleetRules
from server.loops.old_files import OldFilesLoop
from server.store.segments.segment_store import SegmentStore, SegmentStoreError
from server.usecases.fleet import old_scans
from tests.server.api.scans.scanning import PreparedBuilder, put_parcel, scan_map_loop, write_parcel
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair

DAYS = 1e-3  # 86 s


def old_files(server: ServerUnderTest) -> OldFilesLoop:
    store = server.services.scans
    return OldFilesLoop(
        "scans", server.transactions, InlineOffload(), store, old_scans.outdated, old_scans.forget
    )


def scans_of_the_request(server: ServerUnderTest) -> int:
    (request,) = server.get("/scan-requests").json()
    return int(request["scans"])


def test_old_scans_and_a_decided_map_are_deleted_with_their_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = ServerUnderTest(tmp_path / "var", FleetRules(scan_days=DAYS), makes_maps=True)
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    headers = server.sign_in()
    request_id = server.post("/scan-requests", {"name": "Library"}, headers=headers).json()["request_id"]
    data = write_parcel(tmp_path / "one.zip", request_id).read_bytes()
    sha256 = hashlib.sha256(data).hexdigest()
    assert put_parcel(server, data).status_code == 201
    proposal_id = server.post(f"/scan-requests/{request_id}/maps", headers=headers).json()["proposal_id"]
    server.run(scan_map_loop(server, PreparedBuilder()).run_once())
    dismissed = f"/map-proposals/{proposal_id}/dismissal"
    assert server.post(dismissed, {"note": "A lorry."}, headers=headers).status_code == 200
    assert server.post(f"/scan-requests/{request_id}/end", headers=headers).status_code == 200
    store, loop = server.services.scans, old_files(server)

    server.run(loop.run_once())
    assert store.has(sha256)
    server.elapse(90.0)

    def broken(_store: SegmentStore, _sha256: str) -> None:
        raise SegmentStoreError("no bucket answers")

    with monkeypatch.context() as patched:
        patched.setattr(type(store), "remove", broken)
        server.run(loop.run_once())
    assert scans_of_the_request(server) == 2, "tried again in the next hour"

    server.run(loop.run_once())
    assert not store.has(sha256)
    assert scans_of_the_request(server) == 0
    kept = server.get(f"/map-proposals/{proposal_id}").json()
    assert (kept["state"], kept["note"], bool(kept["comparison"])) == ("dismissed", "A lorry.", True)
    picture = server.get(f"/map-proposals/{proposal_id}/picture")
    assert picture.status_code == 409
    assert "its files were deleted with time" in picture.json()["detail"]
    again = server.post(f"/scan-requests/{request_id}/maps", headers=headers)
    assert again.json()["code"] == "no_scans_yet"
    server.close()
