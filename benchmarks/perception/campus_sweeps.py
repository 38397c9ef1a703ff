"""Sweeps of a vehicle's lidars over a campus among people and vehicles who go their own ways."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.sensors.drive import Drive, way_over
from contract.geometry import Array, Pose2
from contract.roads.model import RoadMap
from simulator.fleet import STEP_NS
from simulator.sensors.lidars.driver import moved_to_end
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.lidars.spinning_lidar import LidarScan, MountedLidar, SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from simulator.traffic.actors import Bodies
from vehicle_agent.config import Body
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

PERIOD_NS = 100_000_000
_FLEET_FROM = 1_000_000
# Length, width by kind.
_SIZES = {PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.75, 0.6), VEHICLE: (4.3, 1.8)}
_PACES_MPS = {PEDESTRIAN: (0.8, 1.7), CYCLIST: (2.5, 5.0), VEHICLE: (2.0, 6.0)}
# How far beside the way each kind goes.
_ASIDE_M = {PEDESTRIAN: (1.5, 9.0), CYCLIST: (1.5, 5.0), VEHICLE: (2.2, 4.0)}
_STANDING_RATIO = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """One turn of all lidars.

    stamp_ns    of its end
    scans       as each lidar gives it; points_base (n, 3), intensities (n,): put together at stamp_ns
    pose_map    of the vehicle at stamp_ns, T_map_base (4, 4) the same with height, roll and pitch
    bodies      where the others were then
    """

    stamp_ns: int
    scans: tuple[LidarScan, ...]
    points_base: np.ndarray
    intensities: np.ndarray
    pose_map: Pose2
    T_map_base: Array
    bodies: Bodies


class OthersOnTheirWay:
    """People, cyclists and vehicles who go beside a vehicle's way, in its direction or against it."""

    def __init__(self, way: Array, counts: dict[int, int], rng: np.random.Generator) -> None:
        """way (n, 2); counts by kind. All ways are drawn here, so a moment can be asked in any order."""
        steps = np.hypot(*np.diff(way, axis=0).T)
        keep = np.concatenate(([True], steps > 1e-6))
        self._way = way[keep]
        self._s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(self._way, axis=0).T))))
        kinds = np.concatenate([np.full(count, kind, np.int64) for kind, count in counts.items()])
        n = len(kinds)
        self.kinds, self.numbers = kinds, np.arange(n, dtype=np.int64)
        self._from_m = rng.uniform(0.0, self._s[-1], n)
        side = rng.choice((-1.0, 1.0), n)
        self._aside_m = side * np.array([rng.uniform(*_ASIDE_M[int(kind)]) for kind in kinds])
        paces = np.array([rng.uniform(*_PACES_MPS[int(kind)]) for kind in kinds])
        standing = (rng.random(n) < _STANDING_RATIO) & (kinds == PEDESTRIAN)
        # Vehicles and cyclists keep to the right; people go either way.
        ahead = np.where(kinds == PEDESTRIAN, rng.choice((-1.0, 1.0), n), -side)
        self._pace_mps = np.where(standing, 0.0, ahead * paces)
        self._sway = rng.uniform(0.0, 2.0 * math.pi, n)
        self._facing = rng.uniform(-math.pi, math.pi, n)

    def at(self, time_s: float) -> Bodies:
        """All of them at a moment. Velocities are differences over 20 ms."""
        here, soon = self._places(time_s), self._places(time_s + 0.02)
        velocities = (soon - here) / 0.02
        yaw = np.where(
            np.hypot(*velocities.T) > 0.05, np.arctan2(velocities[:, 1], velocities[:, 0]), self._facing
        )
        sizes = np.array([_SIZES[int(kind)] for kind in self.kinds])
        return Bodies(self.numbers, self.kinds, np.column_stack((here, yaw)), velocities, sizes)

    def _places(self, time_s: float) -> Array:
        s = np.mod(self._from_m + self._pace_mps * time_s, self._s[-1])
        on_foot = (self.kinds == PEDESTRIAN) & (self._pace_mps != 0.0)
        aside = self._aside_m + np.where(on_foot, 0.6 * np.sin(0.7 * time_s + self._sway), 0.0)
        x, y = np.interp(s, self._s, self._way[:, 0]), np.interp(s, self._s, self._way[:, 1])
        step = np.minimum(s + 0.5, self._s[-1])
        back = np.maximum(step - 1.0, 0.0)
        along = np.column_stack(
            [np.interp(step, self._s, c) - np.interp(back, self._s, c) for c in self._way.T]
        )
        along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
        return np.column_stack((x - aside * along[:, 1], y + aside * along[:, 0]))


class CampusSweeps:
    """A drive over a campus; the same seed gives the same sweeps."""

    def __init__(
        self,
        road_map: RoadMap,
        body: Body,
        lidars: tuple[MountedLidar, ...],
        seed: int,
        speed_mps: float = 3.0,
        turns: int = 100,
        counts: dict[int, int] | None = None,
        scene: StaticScene | None = None,
    ) -> None:
        """counts: others by kind; scene: one of the same map, built before."""
        rng = np.random.default_rng([seed, *b"sweeps"])
        self.scene = scene or StaticScene(road_map, seed, WorldChanges(seed=seed))
        way = way_over(road_map, speed_mps * 0.1 * turns + 20.0, rng)
        self._drive = Drive(way, self.scene.ground, speed_mps, body.wheelbase_m)
        self.others = OthersOnTheirWay(way, counts or {PEDESTRIAN: 30, CYCLIST: 4, VEHICLE: 4}, rng)
        own = CastScene(shuttle(body.length_m, body.width_m, body.height_m, body.rear_overhang_m))
        self._lidars = [
            SpinningLidar(mounted, self.scene, np.random.default_rng([seed, number]), own)
            for number, mounted in enumerate(lidars)
        ]
        self._scenes = MovingScenes(self.scene.ground, _FLEET_FROM)
        self._turns, self._speed_mps = turns, speed_mps

    def __iter__(self) -> Iterator[Sweep]:
        for turn in range(self._turns):
            yield self.sweep(turn * PERIOD_NS)

    def sweep(self, begin_ns: int) -> Sweep:
        """The turn that begins then."""
        moving = self._moving(begin_ns)
        scans = tuple(lidar.scan(self._drive.poses, begin_ns, moving) for lidar in self._lidars)
        end_ns = begin_ns + PERIOD_NS
        begin, end = self._drive.pose(begin_ns * 1e-9), self._drive.pose(end_ns * 1e-9)
        turned = math.remainder(float(end[2] - begin[2]), 2.0 * math.pi)
        parts = [
            moved_to_end(
                scan.points_base,
                scan.cloud.offsets_ns,
                PERIOD_NS,
                self._speed_mps,
                turned / (PERIOD_NS * 1e-9),
            )
            for scan in scans
        ]
        return Sweep(
            end_ns,
            scans,
            np.concatenate(parts),
            np.concatenate([scan.cloud.intensities for scan in scans]),
            Pose2(float(end[0]), float(end[1]), math.remainder(float(end[2]), 2.0 * math.pi)),
            self._drive.poses(np.array([end_ns]))[0],
            self.others.at(end_ns * 1e-9),
        )

    def _moving(self, begin_ns: int) -> tuple[MovingBodies, ...]:
        """The bodies of the five ticks of one turn, of those near enough for a return."""
        found = []
        for until_ns in range(begin_ns + STEP_NS, begin_ns + PERIOD_NS + 1, STEP_NS):
            here = self._drive.pose(until_ns * 1e-9)
            others = self.others.at(until_ns * 1e-9)
            near = np.hypot(others.poses_map[:, 0] - here[0], others.poses_map[:, 1] - here[1]) < 70.0
            found.append(MovingBodies(until_ns, self._scenes.of(others.selected(near))))
        return tuple(found)
