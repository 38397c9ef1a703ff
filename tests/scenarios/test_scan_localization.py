"""The Snow Lion stack drives by its scans, without and with GNSS: the worker is beside the tick; replayed."""

import math
from pathlib import Path

import numpy as np
import pytest

from campusloop.virtual.solo_drive import VEHICLE_ID, SoloDrive
from contract.geometry import Array
from contract.point_map.map_files import write_tiles
from contract.point_map.tiles import Surfels
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from contract.runlog.reader import open_segment
from tests.server.feeds.roads.shipped import CAMPUS_MAP
from vehicle_agent.config import Profile
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.signals import Ego
from vehicle_agent.stacks.choice import build_car

TILE_M, VOXEL_M = 32.0, 0.5
NEAR_M = 160.0


def walls_as_surfels(road_map: RoadMap, x_m: float, y_m: float) -> dict[tuple[int, int], Surfels]:
    """Tiles with the buildings' walls around a place, as mapping would find them."""
    means: list[Array] = []
    normals: list[Array] = []
    for building in road_map.buildings:
        outline = np.array(building.outline)
        for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            length_m = float(np.hypot(*(b - a)))
            if min(np.hypot(*(a - (x_m, y_m))), np.hypot(*(b - (x_m, y_m)))) > NEAR_M or length_m < 0.1:
                continue
            along = a + np.linspace(0.0, 1.0, max(2, round(length_m / 0.25)))[:, None] * (b - a)
            heights = np.arange(0.1, min(building.height_m, 12.0), 0.5)
            means.append(np.column_stack((np.repeat(along, len(heights), 0), np.tile(heights, len(along)))))
            across = np.array([(b - a)[1], -(b - a)[0], 0.0]) / length_m
            normals.append(np.tile(across, (len(means[-1]), 1)))
    mean, normal = np.concatenate(means), np.concatenate(normals)
    _, first = np.unique(np.floor(mean / VOXEL_M).astype(int), axis=0, return_index=True)
    mean, normal = mean[first], normal[first]
    at = np.floor(mean[:, :2] / TILE_M).astype(int)
    tiles = {}
    for ix, iy in np.unique(at, axis=0).tolist():
        chosen = (at == (ix, iy)).all(axis=1)
        count = int(chosen.sum())
        tiles[(ix, iy)] = Surfels(mean[chosen], normal[chosen], np.full(count, 0.02), np.full(count, 9.0))
    return tiles


@pytest.fixture(scope="module")
def road_map() -> RoadMap:
    return load_map(CAMPUS_MAP)


def drive_on(road_map: RoadMap, folder: Path, point_map: Path | None) -> SoloDrive:
    drive = SoloDrive(road_map, folder, 1, profile=Profile(stack="snow_lion"), point_map=point_map)
    drive.set_off()
    return drive


def ego_of(drive: SoloDrive) -> Ego:
    assert drive.vehicle.outputs is not None
    return drive.vehicle.outputs.flow.ego


def off_m(drive: SoloDrive) -> float:
    truth, pose = drive.world.truth(VEHICLE_ID).pose_map, ego_of(drive).pose_map
    return math.hypot(truth.x_m - pose.x_m, truth.y_m - pose.y_m)


def believed_age_s(drive: SoloDrive) -> float:
    """Time since the last scan that moved the pose."""
    assert drive.vehicle.wired.computer is not None
    state = drive.vehicle.wired.computer.state
    return 1e-9 * float(drive.now_ns - state.localization.scan_ns)


def run_for(drive: SoloDrive, seconds: float) -> list[float]:
    errors_m = []
    for _ in range(round(50.0 * seconds)):
        drive.step()
        errors_m.append(off_m(drive))
    return errors_m


def test_it_drives_on_by_its_scans_when_gnss_falls_silent_and_replays_exactly(
    road_map: RoadMap, tmp_path: Path
) -> None:
    start = SoloDrive(road_map, tmp_path / "start", 1, lidar=False).world.truth(VEHICLE_ID).pose_map
    point_map = tmp_path / "map"
    index = write_tiles(
        point_map, walls_as_surfels(road_map, start.x_m, start.y_m), TILE_M, VOXEL_M, road_map.origin
    )
    drive = drive_on(road_map, tmp_path / "drive", point_map)
    run_for(drive, 5.0)
    drive.world.gnss[VEHICLE_ID].silent = True
    errors_m = run_for(drive, 11.0)
    assert drive.world.truth(VEHICLE_ID).odometer_m > 15.0
    assert max(errors_m) < 0.2
    assert ego_of(drive).valid
    assert believed_age_s(drive) < 0.5
    drive.vehicle.shut_down()
    (segment,) = (tmp_path / "drive").rglob("*.mcap")
    assert open_segment(segment).header.localization_map == index.map_version
    result = replay_segment(segment, build_car)
    assert result.difference is None
    assert result.ticks > 800
