"""A shuttle that is told of nobody finds people in its scans and stops for them."""

import numpy as np
import pytest

from campusloop.scenes.drive import VEHICLE_ID, SceneDrive
from campusloop.scenes.protection.cells import cells
from campusloop.scenes.stacks import perceiving, profile_of
from vehicle_agent.signals import PEDESTRIAN

pytestmark = pytest.mark.long


def test_a_shuttle_stops_for_a_person_whom_only_its_lidars_show() -> None:
    profile = perceiving(profile_of("snow_lion"), own=True)
    cell = next(one for one in cells(profile.body) if one.name == "day-walks-near-0.50-15.0")
    drive = SceneDrive(cell.scene(profile, 1))
    assert not drive.world.trackers
    errors_m: list[float] = []

    def watch(driven: SceneDrive) -> None:
        assert driven.outputs is not None
        tracks = driven.outputs.flow.world.tracks
        people = tracks.poses_map[tracks.kinds == PEDESTRIAN, :2]
        (place,) = driven.world.bodies().poses_map[:, :2]
        away_m = driven.world.truth(VEHICLE_ID).pose_map
        if len(people) and np.hypot(place[0] - away_m.x_m, place[1] - away_m.y_m) < 15.0:
            errors_m.append(float(np.hypot(*(people - place).T).min()))

    run = drive.run(watch)
    assert run.metrics.front_contacts == ()
    assert run.time_s is not None, "it drove on when the person was gone"
    assert len(errors_m) > 50
    assert float(np.median(errors_m)) < 0.4


@pytest.mark.parametrize(
    ("name", "plant_seed"),
    [
        # A car backs out of its bay at once, and its flank hides that it moves.
        ("day-reverses-bay-8-near-0.75-7.5", 100_204),
        # What is left of the car before the bumper is below the lidars' beams.
        ("day-reverses-bay-beside-van-3-far-0.50-10.0", 100_340),
        # A scooter comes out close behind a parked car, within what the network takes for the car.
        ("day-hidden-scooter-15-1.5-0.50-5.0", 100_052),
    ],
)
def test_what_comes_out_beside_parked_cars_is_not_met(name: str, plant_seed: int) -> None:
    profile = perceiving(profile_of("snow_lion"), own=True)
    cell = next(one for one in cells(profile.body) if one.name == name)
    run = SceneDrive(cell.scene(profile, 1).with_plant(plant_seed)).run()
    assert run.metrics.front_contacts == ()
    assert run.time_s is not None, "it drove on when the way was free"
