"""A driver who keeps straight on and obeys the d/5 - 1 rule by ground truth, through CAN."""

import hashlib

import numpy as np

from simulator.fleet import STEP_NS
from simulator.scoring.metrics import relations
from simulator.world import SimWorld
from vehicle_agent.can.pacmod.codec import pacmod
from vehicle_agent.config import Profile
from vehicle_agent.signals import Actuation

START_NS = 1_000_000_000


class CarefulDriver:
    """Drives `s1` of a world along the x axis at up to `speed_mps`; blind: looks at nobody."""

    def __init__(self, world: SimWorld, speed_mps: float = 3.0, blind: bool = False) -> None:
        self.world, self.now_ns = world, START_NS
        self._speed_mps, self._blind = speed_mps, blind
        self._can = pacmod(Profile())
        self._state = self._can.initial()
        self.digest = hashlib.sha256()

    def drive(self, seconds: float) -> None:
        for _ in range(round(seconds * 50)):
            self._tick()

    def _tick(self) -> None:
        world = self.world
        frames = world.frames_to_vehicle("s1")
        _, self._state = self._can.decode(self._state, frames, self.now_ns)
        items = world.sensor_items("s1", self.now_ns)
        scan = world.scan("s1", self.now_ns)
        self.digest.update(repr((frames, items)).encode())
        if scan is not None:
            self.digest.update(scan[0].tobytes())
        commands, self._state = self._can.encode(self._state, self._act(), self.now_ns)
        world.frames_from_vehicle("s1", commands)
        world.step(self.now_ns)
        self.now_ns += STEP_NS

    def _act(self) -> Actuation:
        truth = self.world.truth("s1")
        steer_rad = -0.3 * truth.pose_map.y_m - 1.0 * truth.pose_map.yaw_rad
        wanted_mps = self._speed_mps if self._blind else min(self._speed_mps, self._free_speed_mps())
        error_mps = wanted_mps - truth.speed_mps
        if wanted_mps < 0.05:
            return Actuation(True, "drive", steer_rad, 0.0, 0.8)
        if error_mps > 0.0:
            return Actuation(True, "drive", steer_rad, min(1.0, 0.08 + 0.5 * error_mps), 0.0)
        return Actuation(True, "drive", steer_rad, 0.0, min(1.0, -0.5 * error_mps))

    def _free_speed_mps(self) -> float:
        world = self.world
        if world.pedestrians is None or not len(world.pedestrians.places):
            return self._speed_mps
        speed_mps = world.truth("s1").speed_mps
        vehicle = np.array([world.truth("s1").pose_map.x_m, 0.0, 0.0, 0.85, 3.5, 0.815, speed_mps])
        ahead = np.column_stack([vehicle[0] + 0.5 * np.arange(121), np.zeros(121)])
        near = relations(vehicle, ahead, world.pedestrians.places)
        wide_m = 0.815 + 0.25 + 0.3 + 0.3 * speed_mps
        before = (near[:, 2] < wide_m) & (near[:, 1] > 0.0) & (near[:, 1] < 5.0 * (speed_mps + 1.0))
        return max(0.0, float(near[before, 1].min()) / 5.0 - 1.0) if before.any() else self._speed_mps
