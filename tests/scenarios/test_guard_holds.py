"""The guard in the whole onboard loop: planning is noise, people step out, and nobody is driven into."""

import math
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np

from campusloop.scenes.contact_metrics import contact_metrics
from campusloop.scenes.drive import VEHICLE_ID, Scene, SceneDrive
from campusloop.scenes.path_map import path_map
from contract.geometry import Array
from simulator.sensors.tracker import TrackerNoise
from simulator.traffic.actors import Bodies, no_bodies
from simulator.world import WorldOptions
from vehicle_agent.config import LidarMount, Profile
from vehicle_agent.signals import PEDESTRIAN, ControlCommand, Tracks

SPEED_MPS = 15.0 / 3.6
START_M = 12.0


@dataclass
class Walker:
    """One person, from a place with a velocity, from a time on."""

    place: tuple[float, float]
    velocity: tuple[float, float]
    from_s: float = 0.0
    hold: bool = False
    clock_s: float = 0.0

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        if not self.hold:
            self.clock_s += dt_s

    def bodies(self) -> Bodies:
        if self.hold:
            return no_bodies()
        walked_s = max(0.0, self.clock_s - self.from_s)
        x, y = (self.place[k] + walked_s * self.velocity[k] for k in (0, 1))
        moving = self.velocity if walked_s > 0.0 else (0.0, 0.0)
        return Bodies(
            np.array([1]),
            np.array([PEDESTRIAN]),
            np.array([[x, y, math.atan2(self.velocity[1], self.velocity[0])]]),
            np.array([moving]),
            np.full((1, 2), 0.5),
        )


class Noise:
    """Control that steers, throttles and brakes at random, whatever the path says."""

    def __init__(self, seed: int, steer_rad: float) -> None:
        self._rng = np.random.default_rng(seed)
        self._steer_rad = steer_rad

    def initial(self) -> None:
        return None

    def step(self, state: None, ego: Any, path: Any, motion: Any) -> tuple[ControlCommand, None]:
        steer_rad = float(self._rng.normal(0.0, self._steer_rad))
        return ControlCommand(steer_rad, float(self._rng.uniform(0.3, 1.0)), 0.0, 1.0), None


class Knowing:
    """A world that knows the truth about people: the guard is what is tested, not the tracker."""

    def __init__(self, room: Any, walker: Walker) -> None:
        self._room, self._walker = room, walker

    def initial(self) -> Any:
        return self._room.initial()

    def step(self, *inputs: Any) -> tuple[Any, Any]:
        world, state = self._room.step(*inputs)
        bodies = self._walker.bodies()
        tracks = Tracks(
            inputs[-1],
            bodies.numbers,
            bodies.kinds,
            bodies.poses_map,
            bodies.velocities_map_mps,
            bodies.sizes_m,
        )
        return msgspec.structs.replace(world, tracks=tracks), state


def drive(
    walker: Walker, seconds: float, noise: Noise | None, start_mps: float = SPEED_MPS
) -> tuple[SceneDrive, float, float]:
    """(the drive, how many front contacts it had, how far it came)."""
    limits = msgspec.structs.replace(Profile().limits, speed_mps_max=SPEED_MPS)
    profile = Profile(limits=limits, lidar=LidarMount(rate_hz=0.0))
    points = np.column_stack((np.arange(0.0, 120.0), np.zeros(120)))
    scene = Scene(
        "guard",
        path_map("guard", points, width_m=4.0, speed_limit_mps=SPEED_MPS),
        profile,
        START_M,
        start_mps,
        110.0,
        seconds,
        1,
        walker,
        WorldOptions(traffic=None, lidar=False, tracker=TrackerNoise()),
    )
    run = SceneDrive(scene)
    car = run.computer._car
    changed: dict[str, Any] = {"world": Knowing(car.world, walker)}
    if noise is not None:
        changed["control"] = noise
    run.computer._car = replace(car, **changed)
    done = run.run()
    rows = done.trace.array()
    return run, len(contact_metrics(rows, done.trace.agents, profile.body).front_contacts), done.driven_m


FRONT_M = Profile().body.front_overhang_m


def test_with_noise_for_a_plan_nobody_who_stands_in_the_way_is_driven_into() -> None:
    for seed in range(3):
        run, contacts, way_m = drive(Walker((START_M + 20.0, 0.1), (0.0, 0.0)), 12.0, Noise(seed, 0.02))
        assert contacts == 0
        assert 14.0 < way_m < 20.0 - FRONT_M
        assert run.world.truth(VEHICLE_ID).speed_mps < 0.05


def test_somebody_who_steps_out_as_late_as_can_be_stopped_for_is_not_touched() -> None:
    # Seen walking for 0.6 s before he is in the way, 4 m before the bumper when he begins.
    out = Walker((START_M + FRONT_M + 8.2, -1.9), (0.0, 1.5), from_s=1.0)
    _, contacts, _ = drive(out, 6.0, None)
    assert contacts == 0


def test_somebody_who_walks_beside_the_vehicle_does_not_stop_it() -> None:
    beside = Walker((START_M + 6.0, -0.5 * Profile().body.width_m - 0.25 - 0.5), (1.3, 0.0))
    _, contacts, way_m = drive(beside, 6.0, None)
    assert contacts == 0
    assert way_m > 5.5 * 3.5


def test_somebody_at_the_body_keeps_it_from_setting_off() -> None:
    at_the_corner = Walker((START_M + FRONT_M + 0.4, 0.6), (0.0, 0.0))
    run, contacts, way_m = drive(at_the_corner, 4.0, None, start_mps=0.0)
    assert contacts == 0
    assert abs(way_m) < 0.05
    assert run.outputs is not None
    assert run.outputs.flow.guard_status.intervened == "somebody close"
