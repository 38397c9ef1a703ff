"""A localization map is put in force while vehicles are connected: each learns of it and fetches it."""

from pathlib import Path

import httpx
import msgspec
import pytest

from contract.localization_manifest import decode_manifest
from contract.roads.load import encode_map, with_version
from contract.roads.model import Origin
from contract.wire.localization_maps import (
    localization_manifest_path,
    localization_tile_path,
    signed_localization_request,
)
from contract.wire.messages import LocalizationMapFailed, LocalizationMapPublished, LocalizationMapStored
from contract.wire.upload import SIGNATURE_HEADER
from server.domain.fleet.vehicles import Vehicle
from server.domain.record.incidents import IncidentKind
from server.store.segments.localization_folder import store_folder
from server.usecases.fleet import campus, localization_maps
from tests.contract.localization_folders import occupancy_map, point_map
from tests.server.api.server_under_test import ServerUnderTest, snow_lion
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair
from vehicle_agent.link.localization_download import LocalizationDownload, LocalizationMapNotTaken

KEY = VehicleKeyPair("shuttle-1")
HERE = snow_lion().origin


@pytest.fixture
def ready(server: ServerUnderTest) -> ServerUnderTest:
    server.enrol("shuttle-1", KEY.public_base64)
    return server


def stored(server: ServerUnderTest, folder: Path) -> str:
    services = server.services
    publishing = store_folder(services.transactions, services.tiles, services.offload, folder, "ann")
    return server.run(publishing).map_version


def put_in_force(server: ServerUnderTest, version: str) -> None:
    server.transact(lambda uow: localization_maps.activate(uow, version, "ann"))
    server.elapse(0.5)


def announced(vehicle: SpokenVehicle) -> list[str]:
    return [told.map_version for told in vehicle.all(LocalizationMapPublished)]


def known(server: ServerUnderTest) -> Vehicle:
    found = server.transact(lambda uow: uow.vehicles.get("shuttle-1"))
    assert isinstance(found, Vehicle)
    return found


def incidents(server: ServerUnderTest) -> list[str]:
    return [one.cause for one in server.transact(lambda uow: uow.views.incidents()) if one.kind == KIND]


KIND = IncidentKind.LOCALIZATION_MAP_NOT_CHANGED


def test_a_vehicle_is_told_of_maps_of_its_kind_until_it_localizes_by_the_one_in_force(
    ready: ServerUnderTest, tmp_path: Path
) -> None:
    point_map(tmp_path / "points", HERE)
    occupancy_map(tmp_path / "cells", HERE)
    points, cells = stored(ready, tmp_path / "points"), stored(ready, tmp_path / "cells")
    vehicle = SpokenVehicle(ready).dial().hello(localizes_by="points")
    put_in_force(ready, cells)
    assert announced(vehicle) == [], "of the other kind"
    put_in_force(ready, points)
    assert announced(vehicle) == [points]
    ready.elapse(7.0)
    assert len(announced(vehicle)) >= 3
    again = SpokenVehicle(ready).dial().hello(localizes_by="points", localization_map=points)
    ready.elapse(4.0)
    assert announced(again) == []
    assert known(ready).localization_map == points
    (shown,) = [one for one in ready_maps(ready) if one["map_version"] == points]
    assert (shown["used_by"], shown["awaited"]) == (["shuttle-1"], [])


def ready_maps(server: ServerUnderTest) -> list[dict[str, object]]:
    server.sign_in()
    answer: list[dict[str, object]] = server.get("/localization-maps").json()
    return answer


def test_a_vehicle_that_compares_no_scans_or_is_older_is_told_nothing(
    ready: ServerUnderTest, tmp_path: Path
) -> None:
    point_map(tmp_path / "points", HERE)
    put_in_force(ready, stored(ready, tmp_path / "points"))
    vehicle = SpokenVehicle(ready).dial().hello()
    ready.elapse(4.0)
    assert (announced(vehicle), vehicle.closed) == ([], "")


def test_a_roll_back_is_announced_to_a_vehicle_on_its_way(ready: ServerUnderTest, tmp_path: Path) -> None:
    point_map(tmp_path / "old", HERE)
    point_map(tmp_path / "new", HERE, changed=1)
    old, new = stored(ready, tmp_path / "old"), stored(ready, tmp_path / "new")
    put_in_force(ready, old)
    vehicle = SpokenVehicle(ready).dial().hello(localizes_by="points", localization_map=old)
    put_in_force(ready, new)
    put_in_force(ready, old)
    assert announced(vehicle) == [new, old]


def test_what_a_vehicle_says_of_the_map_is_shown_and_stops_nothing(
    ready: ServerUnderTest, tmp_path: Path
) -> None:
    point_map(tmp_path / "points", HERE)
    version = stored(ready, tmp_path / "points")
    put_in_force(ready, version)
    vehicle = SpokenVehicle(ready).dial().hello(localizes_by="points")
    before = known(ready).is_available
    vehicle.event(0, LocalizationMapFailed(version, "not_stored", "No space left on device"))
    assert (known(ready).localization_change, known(ready).is_available) == ("not_stored", before)
    assert incidents(ready) == ["not_stored: No space left on device"]
    vehicle.event(1, LocalizationMapStored(version))
    assert known(ready).localization_change == "stored"
    assert incidents(ready) == []
    told = len(announced(vehicle))
    ready.elapse(7.0)
    assert len(announced(vehicle)) == told, "it has the map, and changes over when it stands"
    (shown,) = ready_maps(ready)
    assert shown["awaited"] == [{"vehicle_id": "shuttle-1", "map_version": "", "change": "stored"}]
    vehicle.event(2, LocalizationMapFailed("another", "damaged", "late"))
    assert known(ready).localization_change == "stored", "of a map that is not in force any more"
    SpokenVehicle(ready).dial().hello(localizes_by="points", localization_map=version)
    assert known(ready).localization_change == ""


def test_the_announced_map_can_be_fetched_with_the_vehicles_key_alone(
    ready: ServerUnderTest, tmp_path: Path
) -> None:
    point_map(tmp_path / "points", HERE)
    version = stored(ready, tmp_path / "points")
    put_in_force(ready, version)
    vehicle = SpokenVehicle(ready).dial().hello(localizes_by="points")
    told = vehicle.last(LocalizationMapPublished)
    download = LocalizationDownload(ready.client, "shuttle-1", KEY.sign, told)
    data, manifest = ready.run(download.manifest())
    assert data == (tmp_path / "points" / "index.json").read_bytes()
    for tile in manifest.tiles:
        assert ready.run(download.tile(tile)) == (tmp_path / "points" / tile.file).read_bytes()
    stranger = LocalizationDownload(ready.client, "shuttle-1", VehicleKeyPair("stranger").sign, told)
    with pytest.raises(LocalizationMapNotTaken, match="signature_wrong"):
        ready.run(stranger.manifest())
    with pytest.raises(LocalizationMapNotTaken, match="signature_wrong"):
        ready.run(stranger.tile(manifest.tiles[0]))


def test_a_signature_is_good_for_one_version(ready: ServerUnderTest, tmp_path: Path) -> None:
    point_map(tmp_path / "points", HERE)
    version = stored(ready, tmp_path / "points")
    tile = decode_manifest((tmp_path / "points" / "index.json").read_bytes()).tiles[0]
    other = KEY.sign(signed_localization_request("shuttle-1", 64 * "0"))
    headers = {"Vehicle-Id": "shuttle-1", SIGNATURE_HEADER: other}
    for path in (localization_manifest_path(version), localization_tile_path(version, tile.sha256)):
        answer: httpx.Response = ready.run(ready.client.get(path, headers=headers))
        assert answer.json()["code"] == "signature_wrong"


def test_a_map_is_not_announced_once_the_road_map_lies_in_another_frame(
    ready: ServerUnderTest, tmp_path: Path
) -> None:
    point_map(tmp_path / "points", HERE)
    version = stored(ready, tmp_path / "points")
    put_in_force(ready, version)
    moved = Origin(HERE.latitude_deg + 0.001, HERE.longitude_deg)
    elsewhere = with_version(msgspec.structs.replace(snow_lion(), origin=moved, map_version=""))
    ready.transact(lambda uow: campus.load_map(uow, encode_map(elsewhere), "ann", activate=True))
    vehicle = SpokenVehicle(ready).dial().hello(localizes_by="points")
    ready.elapse(4.0)
    assert announced(vehicle) == []
    (shown,) = ready_maps(ready)
    assert (shown["active"], shown["in_frame"]) == (True, False)
