"""A shuttle that is told of nobody finds people in its scans and stops for them."""

import msgspec
import numpy as np
import pytest

from campusloop.scenes.drive import VEHICLE_ID, Scene, SceneDrive, SceneRun
from campusloop.scenes.path_map import path_map
from campusloop.scenes.protection.cells import cells
from campusloop.scenes.stacks import perceiving, profile_of
from contract.geometry import Array
from simulator.traffic.actors import Bodies, no_bodies
from vehicle_agent.config import PlanarScanner, Profile
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


class AtTheBumper:
    """Somebody who stands before the bumper of a vehicle that is about to set off, and walks away later."""

    def __init__(self, place: tuple[float, float], leaves_s: float) -> None:
        self.hold = False
        self._place, self._leaves_s, self._clock_s = place, leaves_s, 0.0

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        if not self.hold:
            self._clock_s += dt_s

    def bodies(self) -> Bodies:
        if self.hold:
            return no_bodies()
        walked_s = max(0.0, self._clock_s - self._leaves_s)
        velocity = (0.0, 1.2 if walked_s > 0.0 else 0.0)
        return Bodies(
            np.array([1]),
            np.array([PEDESTRIAN]),
            np.array([[self._place[0], self._place[1] + 1.2 * walked_s, 0.5 * np.pi]]),
            np.array([velocity]),
            np.full((1, 2), 0.5),
        )


def sets_off_towards_somebody(profile: Profile) -> SceneRun:
    points = np.column_stack((np.arange(0.0, 80.0), np.zeros(80)))
    bumper_m = 12.0 + profile.body.front_overhang_m
    road_map = path_map("bumper", points, width_m=5.0, speed_limit_mps=3.0)
    person = AtTheBumper((bumper_m + 1.0, 0.2), leaves_s=8.0)
    return SceneDrive(Scene("bumper", road_map, profile, 12.0, 0.0, 40.0, 40.0, 1, person)).run()


def test_a_gem_shuttle_waits_for_somebody_below_the_beams_of_its_lidar() -> None:
    profile = perceiving(profile_of("gem"), own=True)
    run = sets_off_towards_somebody(profile)
    assert run.metrics.front_contacts == ()
    assert run.time_s is not None, "it drove on when the person was gone"
    assert run.time_s > 8.0
    roof_alone = msgspec.structs.replace(profile, people_scanner=PlanarScanner())
    assert sets_off_towards_somebody(roof_alone).metrics.front_contacts, "no lidar on the roof sees them"
