"""Two stacks drive by their scans, without and with GNSS: the worker is beside the tick; replayed."""

import math
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
import pytest

from campusloop.virtual.solo_drive import VEHICLE_ID, SoloDrive
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from contract.runlog.indexed import messages_of
from contract.runlog.matched_scans import AGREES, MatchedScan, points_of
from contract.runlog.reader import open_segment
from contract.runlog.records import SCAN_TOPIC
from tests.scenarios.wall_map import write_wall_map
from tests.server.feeds.roads.shipped import CAMPUS_MAP
from vehicle_agent.config import Profile
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.signals import Ego
from vehicle_agent.stacks.choice import build_car

Stack = Literal["snow_lion", "gem"]


@pytest.fixture(scope="module")
def road_map() -> RoadMap:
    return load_map(CAMPUS_MAP)


def drive_on(
    road_map: RoadMap, folder: Path, point_map: Path | None, stack: Stack = "snow_lion"
) -> SoloDrive:
    drive = SoloDrive(road_map, folder, 1, profile=Profile(stack=stack), point_map=point_map)
    drive.set_off()
    return drive


def ego_of(drive: SoloDrive) -> Ego:
    assert drive.vehicle.outputs is not None
    return drive.vehicle.outputs.flow.ego


def believed_age_s(drive: SoloDrive) -> float:
    """Time since the last scan that moved the pose."""
    assert drive.vehicle.wired.computer is not None
    state = drive.vehicle.wired.computer.state
    return 1e-9 * float(drive.now_ns - state.localization.scan_ns)


def run_for(drive: SoloDrive, seconds: float) -> list[float]:
    errors_m = []
    for _ in range(round(50.0 * seconds)):
        # The world steps after the vehicle: the tick's place is the one before the step.
        truth = drive.world.truth(VEHICLE_ID).pose_map
        drive.step()
        pose = ego_of(drive).pose_map
        errors_m.append(math.hypot(truth.x_m - pose.x_m, truth.y_m - pose.y_m))
    return errors_m


@pytest.mark.parametrize("stack", [pytest.param("snow_lion", marks=pytest.mark.long), "gem"])
def test_it_drives_on_by_its_scans_when_gnss_falls_silent_and_replays_exactly(
    road_map: RoadMap, tmp_path: Path, stack: Stack
) -> None:
    start = SoloDrive(road_map, tmp_path / "start", 1, lidar=False).world.truth(VEHICLE_ID).pose_map
    point_map = tmp_path / "map"
    index = write_wall_map(point_map, road_map, start.x_m, start.y_m)
    drive = drive_on(road_map, tmp_path / "drive", point_map, stack)
    run_for(drive, 5.0)
    drive.world.gnss[VEHICLE_ID].silent = True
    errors_m = run_for(drive, 11.0)
    assert drive.world.truth(VEHICLE_ID).odometer_m > 15.0
    assert max(errors_m) < 0.05
    assert ego_of(drive).valid
    assert believed_age_s(drive) < 0.5
    drive.vehicle.shut_down()
    (segment,) = (tmp_path / "drive").rglob("*.mcap")
    assert open_segment(segment).header.localization_map == index.map_version
    result = replay_segment(segment, build_car)
    assert result.difference is None
    assert result.ticks > 800
    scans = [msgspec.json.decode(one.data, type=MatchedScan) for one in messages_of(segment, (SCAN_TOPIC,))]
    # The worker answers a little late, so one a second may be one less.
    assert 14 <= len(scans) <= 17
    shares = [np.mean(points_of(scan)[1] == AGREES) for scan in scans]
    # This map has walls only, so that the road is new to it.
    assert np.median(shares) > 0.3
