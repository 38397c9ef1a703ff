"""A published map on its way to the vehicle's disk, over a real connection that fails in every way."""

import asyncio
import gzip
import hashlib
from collections.abc import Awaitable, Callable
from pathlib import Path

import httpx
import msgspec
import pytest

from contract.roads.load import encode_map, load_map
from contract.roads.model import RoadMap
from contract.wire.maps import MapFailure, MapPublished, signed_map_request
from contract.wire.messages import MapChangeFailed
from tests.contract.roads.ring_map import ring_map
from tests.full_disk import full_disk
from vehicle_agent.link.map_download import MapNotTaken
from vehicle_agent.link.redial import Redial
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.maps.map_changer import MapChanger

OLD = ring_map()
NEW: RoadMap = msgspec.structs.replace(OLD, name="New name", map_version="")
CONTENT = encode_map(NEW)

Answer = Callable[[bytes, asyncio.StreamWriter], Awaitable[None]]


def published(content: bytes = CONTENT, **fields: object) -> MapPublished:
    version: str = msgspec.json.decode(content)["map_version"]
    announced = MapPublished(1, version, hashlib.sha256(content).hexdigest(), len(content))
    return msgspec.structs.replace(announced, **fields)


def body(content: bytes, status: str = "200 OK") -> bytes:
    head = f"HTTP/1.1 {status}\r\nContent-Encoding: gzip\r\nContent-Length: {len(content)}\r\n\r\n"
    return head.encode() + content


GOOD = body(gzip.compress(CONTENT))


class Vehicle:
    """A vehicle's folder and its changer, against a server that answers each request as the test says.

    answers: bytes for each request, the last one for all that follow; the connection ends after each
    """

    def __init__(self, folder: Path, answers: list[bytes]) -> None:
        self.files = AgentFolder(folder)
        (folder / "map.json").write_bytes(encode_map(OLD))
        self.answers, self.requests = answers, list[bytes]()
        self.reported: list[MapChangeFailed] = []
        self.offered: list[str] = []

    async def run(self, announced: MapPublished, until: Callable[[], bool]) -> MapChanger:
        server = await asyncio.start_server(self._answer, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=30.0) as client:
            changer = self.changer = MapChanger(
                "shuttle-1",
                self.files,
                client,
                lambda text: text.decode().replace("\n", "/"),
                self._report,
                self.offered.append,
                Redial(lambda: 1.0, 0.02, 0.1),
            )
            running = asyncio.create_task(changer.run())
            changer.announced(announced)
            try:
                async with asyncio.timeout(20.0):
                    while not until():
                        changer.announced(announced)
                        await asyncio.sleep(0.01)
            finally:
                running.cancel()
                await asyncio.gather(running, return_exceptions=True)
                server.close()
        return changer

    async def _report(self, event: MapChangeFailed) -> None:
        self.reported.append(event)

    async def _answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.requests.append(await reader.readuntil(b"\r\n\r\n"))
        writer.write(self.answers.pop(0) if len(self.answers) > 1 else self.answers[0])
        await writer.drain()
        writer.close()

    def has_old_map(self) -> bool:
        return load_map(self.files.root / "map.json").map_version == OLD.map_version


def test_a_published_map_is_downloaded_signed_and_compressed_and_offered_to_the_tick(tmp_path: Path) -> None:
    vehicle = Vehicle(tmp_path, [GOOD])
    asyncio.run(vehicle.run(published(), lambda: bool(vehicle.offered)))
    version = published().map_version
    assert set(vehicle.offered) == {version}
    assert vehicle.files.next_map(version).name == "New name"
    assert vehicle.has_old_map()
    (request,) = vehicle.requests
    signed = signed_map_request("shuttle-1", version).decode().replace("\n", "/")
    assert f"Vehicle-Signature: {signed}".lower() in request.decode().lower()
    assert b"gzip" in request
    assert vehicle.reported == []
    vehicle.files.adopt_next_map(version)
    assert load_map(tmp_path / "map.json").map_version == version


OTHER_CAMPUS = encode_map(msgspec.structs.replace(NEW, campus_id="elsewhere"))
UNSOUND = encode_map(msgspec.structs.replace(NEW, sections=()))


@pytest.mark.parametrize(
    ("answer", "announced", "code"),
    [
        (GOOD[:400], published(), "not_downloaded"),
        (b"", published(), "not_downloaded"),
        (body(b"", "503 Service Unavailable"), published(), "not_downloaded"),
        (body(b"", "403 Forbidden"), published(), "not_downloaded"),
        (body(gzip.compress(CONTENT)[:-900] + bytes(900)), published(), "damaged"),
        (body(gzip.compress(CONTENT.replace(b"New name", b"Bad name"))), published(), "damaged"),
        (body(gzip.compress(bytes(50_000_000))), published(), "damaged"),
        (GOOD, published(sha256=64 * "0"), "damaged"),
        (body(gzip.compress(OTHER_CAMPUS)), published(OTHER_CAMPUS), "unsound"),
        (body(gzip.compress(UNSOUND)), published(UNSOUND), "unsound"),
        (GOOD, published(map_version="0123456789abcdef"), "unsound"),
    ],
    ids=[
        "the server dies in the middle",
        "it hangs up",
        "it is busy",
        "it refuses",
        "bytes damaged on the way",
        "another content",
        "a bomb",
        "wrong hash",
        "of another campus",
        "a map with problems",
        "another version than announced",
    ],
)
def test_what_is_no_sound_announced_map_is_told_and_the_old_one_stays(
    tmp_path: Path, answer: bytes, announced: MapPublished, code: MapFailure
) -> None:
    vehicle = Vehicle(tmp_path, [answer])
    asyncio.run(vehicle.run(announced, lambda: len(vehicle.requests) >= 3))
    (told,) = vehicle.reported  # once, however often it is tried
    assert (told.map_version, told.code) == (announced.map_version, code)
    assert told.detail
    assert vehicle.offered == []
    assert vehicle.has_old_map()
    assert list(tmp_path.glob("map-*")) == []


def test_after_failures_the_map_is_taken_all_the_same(tmp_path: Path) -> None:
    damaged = body(gzip.compress(CONTENT)[:-900] + bytes(900))
    vehicle = Vehicle(tmp_path, [b"", GOOD[:700], damaged, GOOD])
    asyncio.run(vehicle.run(published(), lambda: bool(vehicle.offered)))
    assert [event.code for event in vehicle.reported] == ["not_downloaded", "damaged"]
    assert vehicle.files.next_map(published().map_version).name == "New name"


class FullDisk(AgentFolder):
    def save_next_map(self, map_version: str, data: bytes) -> None:
        with full_disk():
            super().save_next_map(map_version, data)


def test_a_full_disk_is_told_and_leaves_the_old_map(tmp_path: Path) -> None:
    vehicle = Vehicle(tmp_path, [GOOD])
    vehicle.files = FullDisk(tmp_path)
    asyncio.run(vehicle.run(published(), lambda: bool(vehicle.reported)))
    assert [event.code for event in vehicle.reported] == ["not_stored"]
    assert vehicle.has_old_map()
    assert list(tmp_path.glob("map-*")) == []
    vehicle.files = AgentFolder(tmp_path)
    asyncio.run(vehicle.run(published(), lambda: bool(vehicle.offered)))


def test_what_the_tick_refuses_is_told_and_tried_again(tmp_path: Path) -> None:
    vehicle = Vehicle(tmp_path, [GOOD])
    version = published().map_version

    def refused_once() -> bool:
        if vehicle.offered and not vehicle.reported:
            vehicle.changer.refused(version, MapNotTaken("off_the_lanes", "beside every road"))
        return len(vehicle.requests) >= 2 and vehicle.offered[-1] == version

    asyncio.run(vehicle.run(published(), refused_once))
    assert [event.code for event in vehicle.reported] == ["off_the_lanes"]
    assert vehicle.has_old_map()


def test_a_roll_back_before_the_change_withdraws_the_offer(tmp_path: Path) -> None:
    vehicle = Vehicle(tmp_path, [GOOD])
    old = published(encode_map(OLD))

    async def scenario() -> None:
        changer = await vehicle.run(published(), lambda: bool(vehicle.offered))
        changer.announced(old)

    asyncio.run(scenario())
    assert vehicle.offered[-1] == ""
