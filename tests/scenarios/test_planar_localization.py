"""The NUS stack drives by its planar laser on the shipped map, without GNSS, and replays exactly."""

import math
from pathlib import Path

import pytest

from campusloop.shipped import DEFAULT_MAP, PROFILES, occupancy_map_of
from campusloop.virtual.solo_drive import VEHICLE_ID, SoloDrive
from contract.roads.load import load_map
from contract.runlog.reader import open_segment
from simulator.sensors.scene_lidars import scene_of_run
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.localization.planar_map.stored_map import checked_index
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car, checked_localization_map

CART = load_profile(PROFILES / "nus-cart.toml")


def test_shipped_map_is_whole_and_of_the_shipped_campus() -> None:
    folder = occupancy_map_of(DEFAULT_MAP)
    assert folder is not None
    index = checked_index(folder, load_map(DEFAULT_MAP).origin)
    assert len(index.tiles) > 500


def test_the_snow_lion_stack_refuses_an_occupancy_map() -> None:
    folder = occupancy_map_of(DEFAULT_MAP)
    assert folder is not None
    with pytest.raises(ValueError, match="index"):
        checked_localization_map(Profile(stack="snow_lion"), folder, load_map(DEFAULT_MAP).origin)


@pytest.mark.long
def test_it_drives_on_by_its_laser_when_gnss_falls_silent_and_replays_exactly(tmp_path: Path) -> None:
    folder = occupancy_map_of(DEFAULT_MAP)
    assert folder is not None
    drive = SoloDrive(
        load_map(DEFAULT_MAP), tmp_path, 1, profile=CART, scene=scene_of_run(3), point_map=folder
    )
    drive.set_off()
    errors_m = []
    for tick in range(30 * 50):
        if tick == 6 * 50:
            drive.world.gnss[VEHICLE_ID].silent = True
        drive.step()
        assert drive.vehicle.outputs is not None
        pose = drive.vehicle.outputs.flow.ego.pose_map
        # The tick's pose is of 20 ms before the world's.
        truth = drive.world.truth(VEHICLE_ID).pose_map
        errors_m.append(math.hypot(truth.x_m - pose.x_m, truth.y_m - pose.y_m))
    assert drive.world.truth(VEHICLE_ID).odometer_m > 30.0
    assert max(errors_m) < 0.2
    ego = drive.vehicle.outputs.flow.ego
    assert ego.valid
    assert ego.position_std_m < 0.3
    drive.vehicle.shut_down()
    (segment,) = tmp_path.rglob("*.mcap")
    index = checked_index(folder, load_map(DEFAULT_MAP).origin)
    assert open_segment(segment).header.localization_map == index.map_version
    assert replay_segment(segment, build_car).difference is None
