"""Vehicles send video; operators with the role for it find it by the run's time, and the audit log knows."""

import asyncio
import hashlib
from datetime import timedelta
from pathlib import Path
from typing import Any

import httpx
import pytest

from contract.video import SEGMENT_HEADER, WEBM_BEGINS, SegmentName, signed_video, video_path
from contract.wire.upload import SIGNATURE_HEADER
from server.api.runs.offload import InlineOffload
from server.domain.instants import moment_of_ns
from server.domain.record.identity import Role
from server.domain.rules import FleetRules
from server.loops.old_files import OldFilesLoop
from server.usecases.fleet import videos
from tests.server.api.security.test_roles import headers_of
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair

KEY = VehicleKeyPair("shuttle-1")
BEGINS_NS = 1_788_250_500_000_000_000
FRONT = SegmentName("front", 5_000_000_000, BEGINS_NS, 60_000)
VIDEO = WEBM_BEGINS + b"pictures" * 100


def put(
    server: ServerUnderTest,
    data: bytes = VIDEO,
    name: str = FRONT.text(),
    *,
    vehicle_id: str = "shuttle-1",
    signed_name: str = "",
    sha256: str = "",
) -> httpx.Response:
    sha256 = sha256 or hashlib.sha256(data).hexdigest()
    signature = VehicleKeyPair(vehicle_id).sign(signed_video(vehicle_id, sha256, signed_name or name))
    headers = {"Vehicle-Id": vehicle_id, SIGNATURE_HEADER: signature, SEGMENT_HEADER: name}
    return server.run(server.client.put(video_path(sha256), content=data, headers=headers))


@pytest.fixture
def headers(server: ServerUnderTest) -> dict[str, str]:
    server.enrol("shuttle-1", KEY.public_base64)
    return server.sign_in()


def span(from_s: float, to_s: float) -> dict[str, str]:
    begin = moment_of_ns(BEGINS_NS)
    return {
        "begin": (begin + timedelta(seconds=from_s)).isoformat(),
        "end": (begin + timedelta(seconds=to_s)).isoformat(),
    }


def watch(server: ServerUnderTest, headers: dict[str, str], from_s: float, to_s: float) -> Any:
    return server.post("/vehicles/shuttle-1/video-views", span(from_s, to_s), headers=headers)


async def played(server: ServerUnderTest, sha256: str, part: str) -> httpx.Response:
    transport = httpx.ASGITransport(server.app)
    async with httpx.AsyncClient(
        transport=transport, base_url="http://campus.test", cookies=server.client.cookies
    ) as client:
        return await client.get(video_path(sha256), headers={"Range": part})


def test_a_segment_is_found_by_the_runs_time_and_played_in_ranges(
    server: ServerUnderTest, headers: dict[str, str]
) -> None:
    assert put(server).status_code == 201
    assert put(server).status_code == 200
    other = SegmentName("rear", 5, BEGINS_NS + 60_000_000_000, 60_000)
    assert put(server, WEBM_BEGINS + b"other", other.text()).status_code == 201
    (found,) = watch(server, headers, 30.0, 59.0).json()["segments"]
    assert (found["camera"], found["size_bytes"]) == ("front", len(VIDEO))
    assert watch(server, headers, -9.0, -1.0).json()["segments"] == []
    assert [one["camera"] for one in watch(server, headers, 0.0, 90.0).json()["segments"]] == [
        "front",
        "rear",
    ]
    # Files are sent by threads, which virtual time has none of.
    part = asyncio.run(played(server, found["sha256"], "bytes=4-11"))
    assert (part.status_code, part.content) == (206, b"pictures")
    assert part.headers["content-type"] == "video/webm"


def test_who_looked_at_which_span_is_in_the_audit_log(
    server: ServerUnderTest, headers: dict[str, str]
) -> None:
    put(server)
    watch(server, headers, 0.0, 60.0)
    newest = server.get("/audit?limit=5").json()
    entry = next(one for one in newest if one["action"] == "watch_video")
    assert entry["subject"] == "shuttle-1"
    assert entry["detail"].startswith(span(0.0, 0.0)["begin"][:16])


def test_a_viewer_sees_no_video(server: ServerUnderTest, headers: dict[str, str]) -> None:
    put(server)
    sha256 = hashlib.sha256(VIDEO).hexdigest()
    viewer = headers_of(server, frozenset[Role]({"viewer"}))
    assert watch(server, viewer, 0.0, 60.0).json()["code"] == "role_missing"
    answer = server.run(server.client.get(video_path(sha256), headers=viewer))
    assert answer.json()["code"] == "role_missing"


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"data": b"no video"}, "video_unreadable"),
        ({"name": "front.webm"}, "video_unreadable"),
        ({"name": SegmentName("front", 1, 2).text()}, "video_unreadable"),
        ({"sha256": 64 * "0"}, "video_hash_wrong"),
        ({"signed_name": SegmentName("front", 1, 2, 3).text()}, "signature_wrong"),
        ({"vehicle_id": "shuttle-9"}, "key_unknown"),
    ],
)
def test_what_is_not_a_vehicles_own_segment_is_refused(
    server: ServerUnderTest, headers: dict[str, str], given: dict[str, Any], code: str
) -> None:
    assert put(server, **given).json()["code"] == code
    assert watch(server, headers, -100.0, 100.0).json()["segments"] == []


def test_a_span_without_end_is_refused(server: ServerUnderTest, headers: dict[str, str]) -> None:
    assert watch(server, headers, 0.0, 7 * 3600.0).json()["code"] == "video_span_invalid"
    assert watch(server, headers, 10.0, 0.0).json()["code"] == "video_span_invalid"


def test_old_video_is_deleted_with_its_bytes(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, FleetRules(video_days=1e-4))
    server.enrol("shuttle-1", KEY.public_base64)
    headers = server.sign_in()
    put(server)
    store, sha256 = server.services.videos, hashlib.sha256(VIDEO).hexdigest()
    loop = OldFilesLoop(
        "videos", server.services.transactions, InlineOffload(), store, videos.outdated, videos.forget
    )
    server.run(loop.run_once())
    assert store.has(sha256)
    server.elapse(10.0)
    server.run(loop.run_once())
    assert not store.has(sha256)
    assert watch(server, headers, 0.0, 60.0).json()["segments"] == []
    server.close()
