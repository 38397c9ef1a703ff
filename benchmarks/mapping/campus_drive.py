"""A drive over the campus with a turning lidar: the vehicle's true motion, and what the lidar makes of it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.localization.campus_way import Way, campus_way, truths
from contract.geometry import Array
from contract.roads.model import RoadMap
from simulator.sensors.lidars.spinning_lidar import MountedLidar, MovingBodies, SpinningLidar
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.mesh import PackedMesh, joined
from simulator.sensors.scene.shapes import car, person
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from vehicle_agent.lidar.models import VLP16
from vehicle_agent.signals.point_cloud import PointCloud

Mount = tuple[float, float, float]

TICK_S = 0.02
SCAN_TICKS = 5
# Of two turns of a VLP-16 at 20 Hz one is used: half the beams of one at 10 Hz, and half the time to cast.
_RATE_HZ = 20.0
# Of the lidar on the Snow Lion shuttle's roof, from the rear axle's centre on the ground.
MOUNT_M: Mount = (3.2, 0.0, 2.63)
_BODY_SWAYS = (0.006, 0.005)


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """The vehicle every 20 ms: (n,) arrays of its rear axle's place, course (unwrapped) and motion."""

    x_m: Array
    y_m: Array
    yaw_rad: Array
    speed_mps: Array
    yaw_rate_radps: Array
    odometer_m: Array

    def __len__(self) -> int:
        return len(self.x_m)

    def until(self, way_m: float) -> "Trace":
        """The first so many metres."""
        end = int(np.searchsorted(self.odometer_m, way_m))
        return Trace(*(getattr(self, name)[:end] for name in self.__slots__))


def trace(way: Way, slip_s2pm: float = 0.0) -> Trace:
    """The whole of a way."""
    rows = [
        (v.pose_map.x_m, v.pose_map.y_m, v.pose_map.yaw_rad, v.speed_mps, v.yaw_rate_radps, v.odometer_m)
        for v in truths(way, slip_s2pm)
    ]
    x, y, yaw, speed, rate, odometer = np.array(rows).T
    return Trace(x, y, np.unwrap(yaw), speed, rate, odometer)


def drawn_trace(road_map: RoadMap, km: float, seed: int) -> Trace:
    """A drive from stop to stop for so many km at up to 3.5 m/s."""
    return trace(campus_way(road_map, km, 3.5, np.random.default_rng([seed, 3])))


class DrivenBody:
    """The vehicle's body on its way: on the road, and on springs."""

    def __init__(
        self, ground: Ground, drive: Trace, rng: np.random.Generator, wheelbase_m: float = 2.6
    ) -> None:
        self._ground, self._drive, self._wheelbase_m = ground, drive, wheelbase_m
        self._phase = rng.uniform(0.0, 2.0 * math.pi, 2)

    def poses(self, times_ns: Array) -> Array:
        """(n, 4, 4) T_map_base at times (n,), ns."""
        drive, times_s = self._drive, 1e-9 * np.asarray(times_ns, dtype=np.float64)
        ticks_s = TICK_S * np.arange(len(drive))
        x, y, yaw, speed = (
            np.interp(times_s, ticks_s, row) for row in (drive.x_m, drive.y_m, drive.yaw_rad, drive.speed_mps)
        )
        sway = np.minimum(1.0, speed)
        roll = sway * _BODY_SWAYS[0] * np.sin(2.3 * times_s + self._phase[0])
        pitch = sway * _BODY_SWAYS[1] * np.sin(3.1 * times_s + self._phase[1])
        turn = np.tile(np.eye(4), (len(times_s), 1, 1))
        cp, sp, cr, sr = np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
        turn[:, 0, 0], turn[:, 0, 1], turn[:, 0, 2] = cp, sp * sr, sp * cr
        turn[:, 1, 1], turn[:, 1, 2] = cr, -sr
        turn[:, 2, 0], turn[:, 2, 1], turn[:, 2, 2] = -sp, cp * sr, cp * cr
        poses: Array = self._ground.poses(np.column_stack((x, y, yaw)), self._wheelbase_m) @ turn
        return poses


class LidarDrive:
    """The scans of one drive. The body rolls and pitches a little on its springs, which no sensor tells."""

    def __init__(self, scene: StaticScene, drive: Trace, seed: int, mount_m: Mount = MOUNT_M) -> None:
        rng = np.random.default_rng([seed, 11])
        self._drive, self._poses = drive, DrivenBody(scene.ground, drive, rng).poses
        T_base_sensor: Array = np.eye(4)
        T_base_sensor[:3, 3] = mount_m
        self.T_base_sensor = T_base_sensor
        mounted = MountedLidar("roof", T_base_sensor, VLP16, _RATE_HZ)
        self._lidar = SpinningLidar(mounted, scene, rng)
        self._traffic = Traffic(drive, scene, rng)

    @property
    def scans(self) -> int:
        return (len(self._drive) - SCAN_TICKS) // SCAN_TICKS

    def pose(self, number: int) -> Array:
        """T_map_sensor (4, 4) at the stamp of a scan."""
        found: Array = self._poses(np.array([stamp_ns(number)]))[0] @ self.T_base_sensor
        return found

    def scan(self, number: int) -> PointCloud:
        """The scan that begins at tick 5 * number; in order, as its noise is drawn."""
        moving = self._traffic.bodies(number * SCAN_TICKS)
        return self._lidar.scan(self._poses, stamp_ns(number), moving).cloud

    def clouds(self) -> Iterator[PointCloud]:
        """All scans in order."""
        for number in range(self.scans):
            yield self.scan(number)


def stamp_ns(number: int) -> int:
    """When a scan begins."""
    return round(1e9 * TICK_S * SCAN_TICKS) * number


class Traffic:
    """A car ahead for some of the way, cars that come along, and people who cross."""

    def __init__(
        self, drive: Trace, scene: StaticScene, rng: np.random.Generator, vehicle: PackedMesh | None = None
    ) -> None:
        """vehicle: the shape of the others; a car without it."""
        self._drive, self._ground = drive, scene.ground
        self._car, self._person = vehicle or car(), person(1.75, 0.3)
        end = len(drive)
        self._oncoming = np.sort(rng.integers(0, end, max(1, end // 3000)))
        self._walkers = np.sort(rng.integers(0, end, max(1, end // 1000)))
        self._side = rng.choice([-1.0, 1.0], len(self._walkers))

    def bodies(self, tick: int) -> tuple[MovingBodies, ...]:
        """All that moves near the vehicle, as it stands at the tick."""
        drive, parts = self._drive, []
        # For a third of the time there is a car ahead.
        if (tick // 4000) % 3 == 1:
            parts.append(self._on_way(self._car, float(drive.odometer_m[tick]) + 14.0, 0.0))
        for begin in self._oncoming:
            # It passes the place of `begin` then, on the other side of the road, at 4 m/s.
            ahead_m = 0.08 * float(begin - tick)
            if abs(ahead_m) < 80.0:
                parts.append(self._on_way(self._car, float(drive.odometer_m[begin]) + ahead_m, 3.2))
        for begin, side in zip(self._walkers, self._side, strict=True):
            off_m = 0.026 * float(tick - begin)
            if abs(off_m) < 20.0:
                at_m = float(drive.odometer_m[begin]) + 12.0
                parts.append(self._on_way(self._person, at_m, float(side) * off_m))
        found = [part for part in parts if part is not None]
        return (MovingBodies(2**62, CastScene(joined(found))),) if found else ()

    def _on_way(self, shape: PackedMesh, at_m: float, left_m: float) -> PackedMesh | None:
        """A shape so far along the vehicle's way and beside it, or None beyond the ends of the way."""
        drive = self._drive
        at = int(np.searchsorted(drive.odometer_m, at_m))
        if not 0 < at < len(drive):
            return None
        yaw = float(drive.yaw_rad[at])
        x = float(drive.x_m[at]) - left_m * math.sin(yaw)
        y = float(drive.y_m[at]) + left_m * math.cos(yaw)
        z = float(self._ground.height_m(np.array([x]), np.array([y]))[0])
        return shape.placed(np.array([[x, y, z, yaw]]), np.ones((1, 3)))
