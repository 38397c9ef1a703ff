"""Localization maps over HTTP: sent, put in force, rolled back, removed; and all that is refused."""

import json
from pathlib import Path
from typing import Any

import httpx
import pytest

from contract.localization_manifest import TILES_MAX, decode_manifest
from contract.point_map.map_files import TileEntry, version_of
from contract.roads.model import Origin
from server.store.segments.localization_folder import store_folder
from server.usecases.fleet import localization_maps
from tests.contract.localization_folders import occupancy_map, point_map
from tests.server.api.server_under_test import ServerUnderTest, snow_lion

PATH = "/localization-maps"
HERE = snow_lion().origin


class Sender:
    """Sends folders as a signed-in operator."""

    def __init__(self, server: ServerUnderTest) -> None:
        self.server = server
        self.headers = server.sign_in()

    def manifest(self, data: bytes, note: str = "") -> httpx.Response:
        headers = {"Content-Type": "application/json", **self.headers}
        params = {"note": note}
        return self.server.request("POST", PATH, content=data, headers=headers, params=params)

    def tile(self, version: str, sha256: str, data: bytes) -> httpx.Response:
        path = f"{PATH}/{version}/tiles/{sha256}"
        return self.server.request("PUT", path, content=data, headers=self.headers)

    def folder(self, folder: Path, note: str = "") -> tuple[str, int]:
        """(version, how many tiles were sent)"""
        data = (folder / "index.json").read_bytes()
        answer = self.manifest(data, note)
        assert answer.status_code == 201, answer.text
        missing = set(answer.json()["missing"])
        files = {tile.sha256: tile.file for tile in decode_manifest(data).tiles}
        for sha256 in missing:
            sent = self.tile(answer.json()["map_version"], sha256, (folder / files[sha256]).read_bytes())
            assert sent.status_code == 204, sent.text
        return answer.json()["map_version"], len(missing)

    def activate(self, version: str) -> httpx.Response:
        return self.server.post(f"{PATH}/{version}/activations", headers=self.headers)

    def remove(self, version: str) -> httpx.Response:
        return self.server.request("DELETE", f"{PATH}/{version}", headers=self.headers)


@pytest.fixture
def sender(server: ServerUnderTest) -> Sender:
    return Sender(server)


def in_force(server: ServerUnderTest) -> list[str]:
    return [one["map_version"] for one in server.get(PATH).json() if one["active"]]


def test_a_map_is_sent_put_in_force_and_rolled_back(sender: Sender, tmp_path: Path) -> None:
    point_map(tmp_path / "old", HERE)
    point_map(tmp_path / "new", HERE, changed=1)
    server = sender.server
    old, sent = sender.folder(tmp_path / "old", "survey of August")
    assert sent == 3
    new, sent = sender.folder(tmp_path / "new")
    assert sent == 1, "only the tile that differs"
    assert in_force(server) == [], "publishing puts nothing in force"
    for version in (old, new, old):
        answer = sender.activate(version)
        assert answer.status_code == 200, answer.text
        assert in_force(server) == [version]
    shown = {one["map_version"]: one for one in server.get(PATH).json()}
    assert shown[old] | {"note": "survey of August", "kind": "points", "tile_count": 3} == shown[old]
    assert (shown[old]["activated_by"], shown[new]["published_by"]) == ("operator", "operator")
    audited = [entry["action"] for entry in server.get("/audit").json()]
    assert audited.count("activate_localization_map") == 3
    assert audited.count("store_localization_map") == 2


def test_one_of_each_kind_is_in_force(sender: Sender, tmp_path: Path) -> None:
    point_map(tmp_path / "points", HERE)
    occupancy_map(tmp_path / "cells", HERE)
    points, _ = sender.folder(tmp_path / "points")
    cells, sent = sender.folder(tmp_path / "cells")
    assert sent == 1, "equal tiles are sent once"
    assert sender.activate(points).json()["kind"] == "points"
    assert sender.activate(cells).json()["kind"] == "occupancy"
    assert sorted(in_force(sender.server)) == sorted((points, cells))


def test_a_stored_tile_is_served_for_ever_and_not_sent_twice(sender: Sender, tmp_path: Path) -> None:
    index = point_map(tmp_path / "map", HERE)
    version, _ = sender.folder(tmp_path / "map")
    tile = index.tiles[0]
    path = f"{PATH}/{version}/tiles/{tile.sha256}"
    answer = sender.server.get(path)
    assert answer.content == (tmp_path / "map" / tile.file).read_bytes()
    assert "immutable" in answer.headers["Cache-Control"]
    again = sender.server.get(path, headers={"If-None-Match": answer.headers["ETag"]})
    assert (again.status_code, again.content) == (304, b"")
    manifest = sender.server.get(f"{PATH}/{version}/manifest")
    assert manifest.content == (tmp_path / "map" / "index.json").read_bytes()
    known = {"If-None-Match": manifest.headers["ETag"]}
    assert sender.server.get(f"{PATH}/{version}/manifest", headers=known).status_code == 304


def test_a_map_that_lacks_a_tile_is_not_put_in_force(sender: Sender, tmp_path: Path) -> None:
    point_map(tmp_path / "map", HERE)
    data = (tmp_path / "map" / "index.json").read_bytes()
    version = sender.manifest(data).json()["map_version"]
    answer = sender.activate(version)
    assert (answer.status_code, answer.json()["code"]) == (409, "localization_map_incomplete")
    assert in_force(sender.server) == []
    # A sender that was cut off goes on where it stopped.
    version, sent = sender.folder(tmp_path / "map")
    assert (sent, sender.activate(version).status_code) == (3, 200)


def test_wrong_tiles_are_refused_and_not_kept(sender: Sender, tmp_path: Path) -> None:
    index = point_map(tmp_path / "map", HERE)
    version = sender.manifest((tmp_path / "map" / "index.json").read_bytes()).json()["map_version"]
    sha256 = index.tiles[0].sha256
    right = (tmp_path / "map" / index.tiles[0].file).read_bytes()
    other = (tmp_path / "map" / index.tiles[1].file).read_bytes()
    for data in (other, right[:-1], b"", right + b"x"):
        answer = sender.tile(version, sha256, data)
        assert (answer.status_code, answer.json()["code"]) == (400, "tile_hash_wrong"), answer.text
    unnamed = sender.tile(version, 64 * "0", right)
    assert (unnamed.status_code, unnamed.json()["code"]) == (404, "localization_tile_unknown")
    unknown = sender.tile(64 * "0", sha256, right)
    assert (unknown.status_code, unknown.json()["code"]) == (404, "localization_map_unknown")
    waiting = sender.server.get(f"{PATH}/{version}/tiles/{sha256}")
    assert (waiting.status_code, waiting.json()["code"]) == (404, "localization_tile_unknown")
    assert len(sender.server.get(f"{PATH}/{version}").json()["missing"]) == 3


def test_a_tile_that_vehicles_could_not_read_is_refused(sender: Sender, tmp_path: Path) -> None:
    """Its hash is right, and it is the tile of another place."""
    index = point_map(tmp_path / "map", HERE)
    document = json.loads((tmp_path / "map" / "index.json").read_bytes())
    document["tiles"][0]["ix"] = 40
    entries = [TileEntry(**one) for one in document["tiles"]]
    document["map_version"] = version_of(entries)
    version = sender.manifest(json.dumps(document).encode()).json()["map_version"]
    data = (tmp_path / "map" / index.tiles[0].file).read_bytes()
    answer = sender.tile(version, index.tiles[0].sha256, data)
    assert (answer.status_code, answer.json()["code"]) == (400, "localization_tile_invalid")


def _changed(folder: Path, **fields: object) -> bytes:
    return json.dumps({**json.loads((folder / "index.json").read_bytes()), **fields}).encode()


def test_what_is_no_manifest_of_this_campus_is_refused(sender: Sender, tmp_path: Path) -> None:
    point_map(tmp_path / "map", HERE)
    point_map(tmp_path / "no-gnss", None)
    point_map(tmp_path / "elsewhere", Origin(HERE.latitude_deg + 0.001, HERE.longitude_deg))
    entry = json.loads((tmp_path / "map" / "index.json").read_bytes())["tiles"][0]
    crowd = [{**entry, "ix": k, "file": f"tiles/{k}.tile"} for k in range(TILES_MAX + 1)]
    escaping = [{**entry, "file": "../../etc/passwd"}]
    for data, code in (
        (b"", "localization_map_invalid"),
        (b"\xff\xfe", "localization_map_invalid"),
        (b"[1, 2]", "localization_map_invalid"),
        (b"[" * 100_000, "localization_map_invalid"),
        (b"{}", "localization_map_invalid"),
        (_changed(tmp_path / "map", format=0), "localization_map_invalid"),
        (_changed(tmp_path / "map", map_version=64 * "0"), "localization_map_invalid"),
        (_changed(tmp_path / "map", tiles=[], map_version=version_of([])), "localization_map_invalid"),
        (_with_tiles(tmp_path / "map", crowd), "localization_map_invalid"),
        (_with_tiles(tmp_path / "map", escaping), "localization_map_invalid"),
        (_with_tiles(tmp_path / "map", [entry, entry]), "localization_map_invalid"),
        (_with_tiles(tmp_path / "map", [{**entry, "bytes": -1}]), "localization_map_invalid"),
        ((tmp_path / "no-gnss" / "index.json").read_bytes(), "localization_map_invalid"),
        ((tmp_path / "elsewhere" / "index.json").read_bytes(), "localization_map_elsewhere"),
    ):
        answer = sender.manifest(data)
        assert answer.json()["code"] == code, (data[:80], answer.text)
        assert answer.status_code in (400, 409)
    assert sender.server.get(PATH).json() == []


def _with_tiles(folder: Path, tiles: list[dict[str, Any]]) -> bytes:
    version = version_of([TileEntry(**one) for one in tiles])
    return _changed(folder, tiles=tiles, map_version=version)


def test_a_removed_map_takes_its_own_tiles_with_it(sender: Sender, tmp_path: Path) -> None:
    first = point_map(tmp_path / "old", HERE)
    point_map(tmp_path / "new", HERE, changed=1)
    old, _ = sender.folder(tmp_path / "old")
    new, _ = sender.folder(tmp_path / "new")
    sender.activate(old)
    refused = sender.remove(old)
    assert (refused.status_code, refused.json()["code"]) == (409, "localization_map_in_force")
    sender.activate(new)
    assert sender.remove(old).status_code == 204
    tiles = sender.server.services.tiles
    assert [tiles.has(one.sha256) for one in first.tiles] == [False, True, True]
    gone = sender.activate(old)
    assert (gone.status_code, gone.json()["code"]) == (404, "localization_map_unknown")
    # It can come again, and only what was deleted is missing.
    assert sender.folder(tmp_path / "old") == (old, 1)


def test_no_more_versions_than_the_server_keeps(
    sender: Sender, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(localization_maps, "LOCALIZATION_MAPS_MAX", 1)
    point_map(tmp_path / "old", HERE)
    point_map(tmp_path / "new", HERE, changed=1)
    sender.folder(tmp_path / "old")
    answer = sender.manifest((tmp_path / "new" / "index.json").read_bytes())
    assert (answer.status_code, answer.json()["code"]) == (409, "too_many_localization_maps")
    assert sender.manifest((tmp_path / "old" / "index.json").read_bytes()).status_code == 201


def test_a_folder_is_published_from_inside_the_server(server: ServerUnderTest, tmp_path: Path) -> None:
    point_map(tmp_path / "map", HERE)
    services = server.services
    for _ in range(2):
        stored = server.run(
            store_folder(
                services.transactions,
                services.tiles,
                services.offload,
                tmp_path / "map",
                "survey",
                "of scans",
            )
        )
    assert server.transact(lambda uow: localization_maps.missing_tiles(uow, stored.map_version)) == ()
    server.transact(lambda uow: localization_maps.activate(uow, stored.map_version, "survey"))
    assert server.transact(lambda uow: uow.localization_maps.in_force()["points"].note) == "of scans"
