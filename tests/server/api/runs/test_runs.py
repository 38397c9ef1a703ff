"""Run segments on their way up, and the scenes and files that come back."""

import hashlib
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from campusloop.scenes.path_map import LANE_ID, path_map
from contract.roads.load import encode_map
from contract.roads.model import ObservationArea
from contract.wire.upload import SIGNATURE_HEADER, segment_path, signed_segment
from tests.contract.runlog.test_segment import UTC_OFFSET_NS, write_segment
from tests.server.api.runs.absent_bucket import use_bucket
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = VehicleKeyPair("shuttle-1")
RUN = "/runs/shuttle-1/boot-1"


@pytest.fixture
def segment(tmp_path: Path) -> bytes:
    path = tmp_path / "0000.mcap"
    write_segment(path, 300)
    return path.read_bytes()


def put(server: ServerUnderTest, data: bytes, key: VehicleKeyPair = KEY, **changes: Any) -> httpx.Response:
    sha256 = changes.get("sha256", hashlib.sha256(data).hexdigest())
    vehicle_id = changes.get("vehicle_id", "shuttle-1")
    headers = {"Vehicle-Id": vehicle_id, SIGNATURE_HEADER: key.sign(signed_segment(vehicle_id, sha256))}
    request = server.client.put(segment_path(sha256), content=data, headers=headers)
    return server.run(request)


@pytest.fixture
def ready(server: ServerUnderTest) -> ServerUnderTest:
    server.enrol("shuttle-1", KEY.public_base64)
    return server


def test_a_segment_is_stored_by_its_hash_and_a_repeat_is_harmless(
    ready: ServerUnderTest, segment: bytes
) -> None:
    first, again = put(ready, segment), put(ready, segment)
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json()["first_ns"] == 20_000_000
    assert first.json()["last_ns"] == 300 * 20_000_000
    ready.sign_in()
    (run,) = ready.get("/runs").json()
    assert (run["boot_id"], run["duration_s"], len(run["segments"])) == ("boot-1", 5.98, 1)
    path = ready.services.segments.fetch(first.json()["sha256"])
    assert path is not None
    assert path.read_bytes() == segment


def test_while_the_object_store_is_away_the_vehicle_is_told_to_send_the_segment_again(
    ready: ServerUnderTest, segment: bytes
) -> None:
    bucket = use_bucket(ready)
    bucket.is_away = True
    refused = put(ready, segment)
    assert (refused.status_code, refused.json()["code"]) == (503, "segment_store_unavailable")
    ready.sign_in()
    assert ready.get("/runs").json() == []
    bucket.is_away = False
    assert put(ready, segment).status_code == 201
    bucket.is_away = True
    for path in (f"/runs/segments/{hashlib.sha256(segment).hexdigest()}", f"{RUN}/scenes", f"{RUN}/map"):
        assert ready.get(path).json()["code"] == "segment_store_unavailable"
    bucket.is_away = False
    assert len(ready.get(f"{RUN}/scenes").json()) > 0


def test_a_segment_that_a_kill_cut_short_is_stored_too(ready: ServerUnderTest, tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    write_segment(path, 4000, close=False)
    data = path.read_bytes()[:-1000]
    answer = put(ready, data)
    assert answer.status_code == 201, answer.text
    assert answer.json()["last_ns"] > answer.json()["first_ns"] > 0


@pytest.mark.parametrize(
    ("changes", "status", "code"),
    [
        ({"sha256": "0" * 64}, 400, "segment_hash_wrong"),
        ({"key": VehicleKeyPair("thief")}, 403, "signature_wrong"),
        ({"vehicle_id": "shuttle-9"}, 404, "key_unknown"),
    ],
)
def test_what_is_not_the_vehicles_own_word_is_refused_and_nothing_is_kept(
    ready: ServerUnderTest, segment: bytes, changes: dict[str, Any], status: int, code: str
) -> None:
    answer = put(ready, segment, **changes)
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    kept = [path for path in (ready.settings.var_dir / "segments").rglob("*") if path.is_file()]
    assert kept == []


def test_another_vehicles_recording_is_refused(server: ServerUnderTest, segment: bytes) -> None:
    other = VehicleKeyPair("shuttle-2")
    server.enrol("shuttle-2", other.public_base64)
    answer = put(server, segment, other, vehicle_id="shuttle-2")
    assert (answer.status_code, answer.json()["code"]) == (403, "signature_wrong")


@pytest.mark.parametrize("data", [b"", b"not a run", b"\x89MCAP0\r\n" + b"\x00" * 200])
def test_bytes_that_are_no_run_are_refused_by_name(ready: ServerUnderTest, data: bytes) -> None:
    answer = put(ready, data)
    assert (answer.status_code, answer.json()["code"]) == (400, "segment_unreadable")


def test_a_segment_larger_than_the_server_takes_is_refused(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, segment_bytes_max=1 << 20)
    server.enrol("shuttle-1", KEY.public_base64)
    answer = put(server, b"x" * ((1 << 20) + 1))
    assert (answer.status_code, answer.json()["code"]) == (413, "segment_too_large")
    server.close()


def test_a_run_comes_back_as_scenes_in_the_live_views_shape(ready: ServerUnderTest, segment: bytes) -> None:
    put(ready, segment)
    ready.sign_in()
    scenes = ready.get(f"{RUN}/scenes", params={"step_ms": 1000}).json()
    start_ms = UTC_OFFSET_NS // 1_000_000
    assert [scene["at_ms"] - start_ms for scene in scenes] == [200, 1200, 2200, 3200, 4200, 5200]
    shuttle = scenes[0]["vehicles"][0]
    assert (shuttle["vehicle_id"], shuttle["status"]["pose_map"][0], shuttle["status"]["speed_mps"]) == (
        "shuttle-1",
        1.0,
        3.0,
    )
    part = ready.get(f"{RUN}/scenes", params={"from_ms": start_ms + 3000, "to_ms": start_ms + 3500}).json()
    assert [scene["at_ms"] - start_ms for scene in part] == [3000, 3200, 3400]
    assert len(ready.get(f"{RUN}/scenes", params={"limit": 2}).json()) == 2


def test_runs_are_for_operators_and_unknown_ones_are_a_404(ready: ServerUnderTest) -> None:
    for path in ("/runs", RUN, f"{RUN}/scenes", "/runs/segments/" + "0" * 64):
        assert ready.get(path).status_code == 401
    ready.sign_in()
    assert ready.get(RUN).json()["code"] == "run_unknown"
    assert ready.get("/runs/segments/" + "0" * 64).json()["code"] == "segment_unknown"


def test_a_run_brings_the_map_that_it_was_driven_on(ready: ServerUnderTest, tmp_path: Path) -> None:
    points = np.array([[0.0, 0.0], [30.0, 0.0]])
    area = ObservationArea("zebra", "crossing", ((9.0, -4.0), (9.0, 4.0), (12.0, 4.0)), ((LANE_ID, 8.0),))
    other = path_map("elsewhere", points, width_m=4.0, speed_limit_mps=3.0, areas=(area,))
    write_segment(tmp_path / "own.mcap", 20, road_map=encode_map(other))
    put(ready, (tmp_path / "own.mcap").read_bytes())
    assert ready.get(f"{RUN}/map").status_code == 401
    ready.sign_in()
    shape = ready.get(f"{RUN}/map").json()
    assert shape["map_version"] == other.map_version
    assert shape["lanes"][0]["xy"] == [0.0, 0.0, 30.0, 0.0]
    assert shape["areas"] == [
        {"area_id": "zebra", "kind": "crossing", "xy": [9.0, -4.0, 9.0, 4.0, 12.0, 4.0]}
    ]


def test_a_run_whose_map_cannot_be_read_says_so(ready: ServerUnderTest, segment: bytes) -> None:
    put(ready, segment)
    ready.sign_in()
    answer = ready.get(f"{RUN}/map")
    assert (answer.status_code, answer.json()["code"]) == (404, "run_map_unreadable")
