"""A published localization map on its way to the vehicle's disk: whole, from what is there, or not at all."""

import asyncio
import hashlib
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest

from contract.localization_manifest import decode_manifest
from contract.roads.load import encode_map
from contract.roads.model import Origin
from contract.wire.localization_maps import LocalizationMapFailure, LocalizationMapPublished
from contract.wire.messages import LocalizationMapFailed, LocalizationMapStored
from tests.contract.localization_folders import occupancy_map, point_map
from tests.contract.roads.ring_map import ring_map
from tests.full_disk import full_disk
from vehicle_agent.link.redial import Redial
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.maps.localization_changer import LocalizationChanger
from vehicle_agent.runtime.processes.maps.localization_files import LocalizationFiles

ROADS = ring_map()


class Server:
    """Serves one folder. `spoil` changes the n-th answer, from 0; None: the link is cut."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.data = (folder / "index.json").read_bytes()
        self.manifest = decode_manifest(self.data)
        self.asked: list[str] = []
        self.spoil: Callable[[int, bytes], bytes | None] = lambda _number, content: content

    @property
    def announcement(self) -> LocalizationMapPublished:
        sha256 = hashlib.sha256(self.data).hexdigest()
        return LocalizationMapPublished(
            1, self.manifest.kind, self.manifest.map_version, sha256, len(self.data)
        )

    def answer(self, request: httpx.Request) -> httpx.Response:
        assert request.headers["Vehicle-Signature"].startswith("campusloop-localization-map/shuttle-1/")
        name = request.url.path.rsplit("/", 1)[-1]
        self.asked.append(name)
        if name == "vehicle-manifest":
            content = self.data
        else:
            (content,) = {
                (self.folder / tile.file).read_bytes() for tile in self.manifest.tiles if tile.sha256 == name
            }
        sent = self.spoil(len(self.asked) - 1, content)
        if sent is None:
            raise httpx.ReadError("cut off", request=request)
        return httpx.Response(200, content=sent)

    def tiles_asked(self) -> int:
        return sum(name != "vehicle-manifest" for name in self.asked)


class Vehicle:
    """A vehicle's folder and its changer."""

    def __init__(self, folder: Path, files: LocalizationFiles | None = None) -> None:
        folder.mkdir()
        self.files = AgentFolder(folder)
        self.files.localization = files or LocalizationFiles(folder, reserve_bytes=0)
        (folder / "map.json").write_bytes(encode_map(ROADS))
        (folder / "profile.toml").write_text('stack = "snow_lion"\n')
        self.reported: list[LocalizationMapStored | LocalizationMapFailed] = []
        self.offered: list[str] = []

    async def _run(self, server: Server, until: Callable[[], bool]) -> None:
        transport = httpx.MockTransport(server.answer)
        async with httpx.AsyncClient(transport=transport, base_url="http://campus.test") as client:
            changer = LocalizationChanger(
                "shuttle-1",
                self.files,
                client,
                lambda text: text.decode().replace("\n", "/"),
                self._report,
                self.offered.append,
                Redial(lambda: 1.0, 0.01, 0.02),
            )
            running = asyncio.create_task(changer.run())
            try:
                async with asyncio.timeout(20.0):
                    while not until():
                        changer.announced(server.announcement)
                        await asyncio.sleep(0.005)
            finally:
                running.cancel()
                await asyncio.gather(running, return_exceptions=True)

    def fetch(self, server: Server, until: Callable[[], bool] | None = None) -> None:
        asyncio.run(self._run(server, until or (lambda: bool(self.offered))))

    async def _report(self, event: LocalizationMapStored | LocalizationMapFailed) -> None:
        self.reported.append(event)

    def codes(self) -> list[str]:
        return [event.code for event in self.reported if isinstance(event, LocalizationMapFailed)]


def test_a_map_is_fetched_offered_and_taken_over_tile_by_tile(tmp_path: Path) -> None:
    point_map(tmp_path / "old", ROADS.origin)
    point_map(tmp_path / "new", ROADS.origin, changed=1)
    vehicle, old = Vehicle(tmp_path / "vehicle"), Server(tmp_path / "old")
    vehicle.fetch(old)
    version = old.manifest.map_version
    assert set(vehicle.offered) == {version}
    assert vehicle.reported == [LocalizationMapStored(version)]
    assert vehicle.files.localization.in_force() is None, "nothing changes before the tick has changed over"
    vehicle.files.localization.adopt(version)
    found = vehicle.files.checked_point_map()
    assert found is not None
    assert found.map_version == version
    new = Server(tmp_path / "new")
    vehicle.offered.clear()
    vehicle.fetch(new)
    assert new.tiles_asked() == 1, "the other tiles are on the disk already"
    # A roll back finds everything there.
    vehicle.files.localization.adopt(new.manifest.map_version)
    vehicle.offered.clear()
    old.asked.clear()
    vehicle.fetch(old)
    assert old.asked == []


def test_a_roll_back_to_a_map_that_was_damaged_meanwhile_fetches_what_is_wrong(tmp_path: Path) -> None:
    point_map(tmp_path / "old", ROADS.origin)
    point_map(tmp_path / "new", ROADS.origin, changed=3)
    vehicle, old, new = (
        Vehicle(tmp_path / "vehicle"),
        Server(tmp_path / "old"),
        Server(tmp_path / "new"),
    )
    for server in (old, new):
        vehicle.offered.clear()
        vehicle.fetch(server)
        vehicle.files.localization.adopt(server.manifest.map_version)
    kept = vehicle.files.localization.root / old.manifest.map_version
    (kept / old.manifest.tiles[0].file).write_bytes(b"rot")
    old.asked.clear()
    vehicle.offered.clear()
    vehicle.fetch(old)
    assert old.tiles_asked() == 3
    vehicle.files.localization.adopt(old.manifest.map_version)
    assert vehicle.files.checked_point_map() is not None


def test_a_fetch_that_was_cut_off_goes_on_where_it_stopped(tmp_path: Path) -> None:
    point_map(tmp_path / "map", ROADS.origin, tiles=6)
    vehicle, server = Vehicle(tmp_path / "vehicle"), Server(tmp_path / "map")
    server.spoil = lambda number, content: None if number == 4 else content
    vehicle.fetch(server)
    assert vehicle.codes() == ["not_downloaded"]
    assert vehicle.reported[-1] == LocalizationMapStored(server.manifest.map_version)
    assert server.tiles_asked() == 7, "the tile that was cut is asked for again, and no other"


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (lambda number, content: content[:-1] + b"x" if number % 3 == 2 else content, "damaged"),
        (lambda number, content: content + b"more" if number % 3 == 2 else content, "damaged"),
        (lambda number, content: b"{}" if number == 0 else content, "damaged"),
    ],
    ids=["a tile with another hash", "a tile that is too long", "another manifest"],
)
def test_damaged_bytes_are_told_and_fetched_again(
    tmp_path: Path, spoil: Callable[[int, bytes], bytes], code: LocalizationMapFailure
) -> None:
    point_map(tmp_path / "map", ROADS.origin)
    vehicle, server = Vehicle(tmp_path / "vehicle"), Server(tmp_path / "map")
    server.spoil = spoil
    vehicle.fetch(server, lambda: bool(vehicle.codes()) and len(server.asked) > 4)
    assert vehicle.codes() == [code], "once, however often it is tried"
    assert vehicle.files.localization.in_force() is None


def test_a_map_of_another_frame_or_kind_is_not_fetched(tmp_path: Path) -> None:
    elsewhere = Origin(ROADS.origin.latitude_deg + 0.01, ROADS.origin.longitude_deg)
    point_map(tmp_path / "elsewhere", elsewhere)
    occupancy_map(tmp_path / "cells", ROADS.origin)
    vehicle, server = Vehicle(tmp_path / "vehicle"), Server(tmp_path / "elsewhere")
    vehicle.fetch(server, lambda: bool(vehicle.codes()))
    assert (vehicle.codes(), server.tiles_asked()) == (["elsewhere"], 0)
    vehicle.reported.clear()
    vehicle.fetch(Server(tmp_path / "cells"), lambda: bool(vehicle.codes()))
    assert vehicle.codes() == ["unsound"]
    assert vehicle.offered == []


class FullDisk(LocalizationFiles):
    def save_tile(self, *arguments: object) -> None:
        with full_disk():
            super().save_tile(*arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("full", [FullDisk, LocalizationFiles], ids=["full", "too little room"])
def test_a_full_disk_is_told_and_leaves_the_old_map_and_no_rest(
    tmp_path: Path, full: type[LocalizationFiles]
) -> None:
    point_map(tmp_path / "old", ROADS.origin)
    point_map(tmp_path / "new", ROADS.origin, changed=2)
    reserve_bytes = 1 << 60 if full is LocalizationFiles else 0
    vehicle = Vehicle(tmp_path / "vehicle", full(tmp_path / "vehicle", reserve_bytes))
    old = vehicle.files.install_point_map(tmp_path / "old")
    vehicle.fetch(Server(tmp_path / "new"), lambda: bool(vehicle.codes()))
    assert vehicle.codes() == ["not_stored"]
    assert vehicle.files.checked_point_map() == old
    assert [path.name for path in vehicle.files.localization.root.rglob("*.tile")] == []


def test_a_fetched_map_that_is_damaged_on_the_disk_is_removed_and_fetched_again(tmp_path: Path) -> None:
    index = point_map(tmp_path / "map", ROADS.origin)
    vehicle, server = Vehicle(tmp_path / "vehicle"), Server(tmp_path / "map")
    vehicle.fetch(server)
    vehicle.files.localization.adopt(index.map_version)
    folder = vehicle.files.localization.in_force()
    assert folder is not None
    (folder / index.tiles[0].file).write_bytes(b"rot")
    assert vehicle.files.checked_point_map() is None
    vehicle.offered.clear()
    vehicle.fetch(server)
    vehicle.files.localization.adopt(index.map_version)
    assert vehicle.files.checked_point_map() is not None


def test_what_was_given_by_hand_counts_until_the_server_announces_a_map(tmp_path: Path) -> None:
    point_map(tmp_path / "old", ROADS.origin)
    point_map(tmp_path / "new", ROADS.origin, changed=1)
    vehicle = Vehicle(tmp_path / "vehicle")
    vehicle.fetch(Server(tmp_path / "new"))
    vehicle.files.localization.adopt(Server(tmp_path / "new").manifest.map_version)
    by_hand = vehicle.files.install_point_map(tmp_path / "old")
    assert vehicle.files.checked_point_map() == by_hand


def test_only_the_map_in_force_the_one_before_and_the_wanted_one_are_kept(tmp_path: Path) -> None:
    vehicle = Vehicle(tmp_path / "vehicle")
    versions = []
    for number in range(4):
        point_map(tmp_path / str(number), ROADS.origin, changed=1, moved_m=0.1 * number)
        server = Server(tmp_path / str(number))
        vehicle.offered.clear()
        vehicle.fetch(server)
        versions.append(server.manifest.map_version)
        vehicle.files.localization.adopt(versions[-1])
    kept = {path.name for path in vehicle.files.localization.root.iterdir() if path.is_dir()}
    assert kept == set(versions[1:]), "that before the one before goes with the next fetch"


def test_a_disk_that_fails_while_old_maps_are_removed_is_said_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    point_map(tmp_path / "new", ROADS.origin)
    vehicle, server, looks = Vehicle(tmp_path / "vehicle"), Server(tmp_path / "new"), [0]
    prune = vehicle.files.localization.prune

    def broken_once(map_version: str) -> None:
        looks[0] += 1
        if looks[0] == 1:
            raise OSError("input/output error")
        prune(map_version)

    monkeypatch.setattr(vehicle.files.localization, "prune", broken_once)
    vehicle.fetch(server)
    assert vehicle.codes() == ["not_stored"]
    assert set(vehicle.offered) == {server.manifest.map_version}
