"""A localization map is put in force while a shuttle drives: it fetches it, changes over and back."""

import asyncio
from pathlib import Path
from typing import Any

import httpx
import pytest

from campusloop.live.campus import LiveCampus, LiveOptions
from campusloop.shipped import PROFILES
from contract.localization_manifest import decode_manifest
from contract.point_map.map_files import read_index, read_tile, write_tiles
from contract.roads.load import load_map
from contract.runlog.reader import open_segment
from contract.runlog.records import NO_LOCALIZATION_MAP
from simulator.start_places import start_poses
from tests.faults.real_campus import free_port
from tests.scenarios.wall_map import TILE_M, VOXEL_M, write_wall_map
from tests.server.feeds.roads.shipped import CAMPUS_MAP
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

# `make soak-maps`: CI has no room for its minute.
pytestmark = pytest.mark.faults

API = "/api/v1/localization-maps"
VEHICLE = "shuttle-1"
WITHIN = 600  # fifths of a second


async def send(client: httpx.AsyncClient, headers: dict[str, str], folder: Path) -> str:
    data = (folder / "index.json").read_bytes()
    typed = headers | {"Content-Type": "application/json"}
    stored = (await client.post(API, content=data, headers=typed)).raise_for_status().json()
    files = {tile.sha256: tile.file for tile in decode_manifest(data).tiles}
    for sha256 in stored["missing"]:
        path = f"{API}/{stored['map_version']}/tiles/{sha256}"
        content = (folder / files[sha256]).read_bytes()
        (await client.put(path, content=content, headers=headers)).raise_for_status()
    return str(stored["map_version"])


async def until_used(campus: LiveCampus, version: str) -> dict[str, Any]:
    """The vehicle's status once it localizes by this version and says that scans agree."""
    for _ in range(WITHIN):
        shown = (await campus.client.get(f"{API}/{version}", headers=campus.operator.headers)).json()
        vehicle: dict[str, Any] = {**await campus.operator.vehicle(VEHICLE)}
        status = vehicle["status"] or {}
        if shown["used_by"] == [VEHICLE] and (status.get("localization") or {}).get("phase") == "tracking":
            return dict(status)
        campus._shuttles.restart_ended()
        await asyncio.sleep(0.2)
    raise AssertionError(f"{VEHICLE} does not localize by {version}: {shown} {status}")


def test_a_shuttle_gets_its_first_map_and_another_one_and_goes_back(tmp_path: Path) -> None:
    road_map = load_map(CAMPUS_MAP)
    start = start_poses(road_map, (VEHICLE,))[VEHICLE]
    write_wall_map(tmp_path / "whole", road_map, start.x_m, start.y_m)
    whole = read_index(tmp_path / "whole")
    tiles = {(one.ix, one.iy): read_tile(tmp_path / "whole", one) for one in whole.tiles}
    farthest = max(tiles, key=lambda at: abs(at[0] * TILE_M - start.x_m) + abs(at[1] * TILE_M - start.y_m))
    del tiles[farthest]
    write_tiles(tmp_path / "other", tiles, TILE_M, VOXEL_M, road_map.origin)
    options = LiveOptions(
        CAMPUS_MAP,
        tmp_path / "campus",
        1,
        port=free_port(),
        base_port=49_300,
        pedestrians=False,
        profile_path=PROFILES / "snow-lion.toml",
        by_scans=True,
    )

    async def scenario() -> tuple[str, str]:
        campus = LiveCampus(options)
        try:
            await campus.start()
            headers = campus.operator.headers
            first = await send(campus.client, headers, tmp_path / "whole")
            other = await send(campus.client, headers, tmp_path / "other")
            for version in (first, other, first):
                path = f"{API}/{version}/activations"
                (await campus.client.post(path, headers=headers)).raise_for_status()
                status = await until_used(campus, version)
                assert status["localization"]["agreement"] > 0.7
            return first, other
        finally:
            await campus.stop()

    first, other = asyncio.run(scenario())
    vehicle = tmp_path / "campus" / "vehicles" / VEHICLE
    kept = {path.name for path in (vehicle / "localization-maps").iterdir() if path.is_dir()}
    assert kept == {first, other}
    segments = sorted(vehicle.rglob("*.mcap"))
    compared = {open_segment(path).header.localization_map for path in segments}
    assert compared == {NO_LOCALIZATION_MAP, first, other}
    for segment in segments:
        assert replay_segment(segment, build_car).difference is None
