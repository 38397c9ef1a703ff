"""Random drives with a lidar and an inertial unit whose poses are known, through the simulator's sensors."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.odometry.simulated import houses
from contract.geometry import Array
from contract.roads.model import Building, Lane, Origin, RoadMap
from contract.transforms import inverse, transform_of
from simulator.sensors.inertial_unit import InertialNoise, InertialUnit
from simulator.sensors.lidars.mounts import in_makers_frame
from simulator.sensors.lidars.spinning_lidar import MountedLidar, SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from vehicle_agent.lidar.models import VLP16, XT16, XT32
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.motion_calibration.drive import InertialDrive, inertial_drive

Way = Literal["bends", "straight", "stands"]
_MODELS = (VLP16, XT16, XT32)
_PERIOD_NS = 100_000_000
_STEP_M, _STEP_S = 0.02, 0.05
_STANDS_S = 2.0
_LANE_STEP_M = 0.8
_START_NS = 1_000_000_000
# The unit records longer than the lidar, to both sides.
_AROUND_NS = 500_000_000


@dataclass(frozen=True, slots=True)
class Sway:
    """Roll, pitch and heave of the body: amplitudes (rad, rad, m) and angular frequencies."""

    amplitudes: tuple[float, float, float]
    rates_radps: tuple[float, float, float]


class MotionDrive:
    """One random vehicle and its drive; the same for the same seed.

    T_lidar_unit  the truth; offset_s: has to be added to the unit's stamps to be the lidar's time
    """

    def __init__(self, seed: int, way: Way = "bends", duration_s: float = 60.0) -> None:
        rng = np.random.default_rng([seed, 77])
        self.model = _MODELS[int(rng.integers(len(_MODELS)))]
        self._way = _track(way, duration_s, rng)
        # An accelerometer would feel the corners of a polyline.
        self._places = CubicSpline(self._way[:, 0], self._way[:, 1:])
        scene = StaticScene(_street(self._way[:, 1:3], rng), seed, WorldChanges(seed=seed))
        self._ground = scene.ground
        self._sway = Sway(
            (rng.uniform(0.004, 0.015), rng.uniform(0.004, 0.012), rng.uniform(0.005, 0.025)),
            (rng.uniform(1.5, 3.0), rng.uniform(2.0, 4.0), rng.uniform(1.5, 5.0)),
        )
        roll, pitch = np.radians(rng.uniform(-8.0, 8.0, 2))
        place = np.append(rng.uniform(-1.0, 2.5), (rng.uniform(-0.5, 0.5), rng.uniform(1.9, 2.4)))
        T_base_level = transform_of(roll, pitch, rng.uniform(-math.pi, math.pi), place)
        T_base_lidar = in_makers_frame(T_base_level, self.model)
        tilts = rng.uniform(-0.5, 0.5, 2)
        inside = np.array([rng.uniform(-0.3, 1.8), rng.uniform(-0.5, 0.5), rng.uniform(0.3, 1.0)])
        T_base_unit = transform_of(tilts[0], tilts[1], rng.uniform(-math.pi, math.pi), inside)
        self.T_lidar_unit = inverse(T_base_lidar) @ T_base_unit
        # Up to 0.3 s apart, or clocks that began at different times.
        self.offset_s = float(rng.uniform(-0.3, 0.3) if rng.random() < 0.75 else rng.uniform(-9e5, 9e5))
        self._lidar = SpinningLidar(
            MountedLidar("top", T_base_lidar, self.model), scene, np.random.default_rng([seed, 1])
        )
        self._unit = InertialUnit(T_base_unit, _noise(rng), np.random.default_rng([seed, 2]))
        self._rate_hz = float(rng.choice([100.0, 200.0]))
        self.T_base_lidar = T_base_lidar
        self.scans = math.floor(float(self._way[-1, 0]) * 1e9 / _PERIOD_NS)

    def clouds(self) -> Iterator[PointCloud]:
        """The scans in order, each begun at its stamp, in the lidar's clock."""
        for number in range(self.scans):
            yield self._lidar.scan(self._poses, _START_NS + number * _PERIOD_NS).cloud

    def lidar_poses(self) -> Array:
        """(scans, 4, 4) T_first_lidar at the stamps, true."""
        poses = self._poses(_START_NS + _PERIOD_NS * np.arange(self.scans)) @ self.T_base_lidar
        relative: Array = np.linalg.inv(poses[0]) @ poses
        return relative

    def inertial(self) -> InertialDrive:
        """The unit's samples, in its own clock."""
        end_ns = _START_NS + self.scans * _PERIOD_NS + _AROUND_NS
        stamps_ns = np.arange(_START_NS - _AROUND_NS, end_ns, round(1e9 / self._rate_hz))
        samples = self._unit.samples(self._poses, stamps_ns)
        stamped_ns = stamps_ns - round(self.offset_s * 1e9)
        return inertial_drive(stamped_ns, samples.rates_radps, samples.specific_force_mps2)

    def _poses(self, times_ns: np.ndarray) -> Array:
        """(n, 4, 4) T_map_base: on the road, rolling, pitching and heaving with the speed."""
        times_s = (np.asarray(times_ns) - _START_NS) * 1e-9
        t, x = self._way[:, 0], self._way[:, 1]
        poses = self._ground.poses(self._places(np.clip(times_s, t[0], t[-1])))
        (roll, pitch, heave), (a, b, c) = self._sway.amplitudes, self._sway.rates_radps
        swayed: Array = np.tile(np.eye(4), (len(times_s), 1, 1))
        if t[-1] > 0.0 and x[-1] != x[0]:
            p, q = roll * np.sin(a * times_s), pitch * np.sin(b * times_s + 1.0)
            swayed[:, 0, 0], swayed[:, 0, 2], swayed[:, 2, 0], swayed[:, 2, 2] = (
                np.cos(q), np.sin(q), -np.sin(q), np.cos(q),
            )  # fmt: skip
            rolled: Array = np.tile(np.eye(4), (len(times_s), 1, 1))
            rolled[:, 1, 1], rolled[:, 1, 2], rolled[:, 2, 1], rolled[:, 2, 2] = (
                np.cos(p), -np.sin(p), np.sin(p), np.cos(p),
            )  # fmt: skip
            swayed = swayed @ rolled
            swayed[:, 2, 3] = heave * np.sin(c * times_s)
        moved: Array = poses @ swayed
        return moved


def _noise(rng: np.random.Generator) -> InertialNoise:
    """From a good unit to one of a telephone."""
    factor = float(np.exp(rng.uniform(math.log(0.5), math.log(3.0))))
    usual = InertialNoise()
    return InertialNoise(
        factor * usual.force_std_mps2, factor * usual.force_bias_std_mps2, factor * usual.force_walk_mps2,
        factor * usual.force_scale_std, factor * usual.rate_std_radps,
        factor * 4.0 * usual.rate_bias_std_radps, factor * usual.rate_walk_radps,
        factor * usual.rate_scale_std, factor * usual.cross_axis_rad_std,
    )  # fmt: skip


def _track(kind: Way, duration_s: float, rng: np.random.Generator) -> Array:
    """(n, 4) time, x, y, yaw: bends to both sides, a straight street, or one place."""
    if kind == "stands":
        return np.array([[0.0, 0.0, 0.0, 0.3], [duration_s, 0.0, 0.0, 0.3]])
    top_mps = rng.uniform(2.5, 5.0)
    length_m = top_mps * duration_s * 0.8
    kappa: list[Array] = []
    while kind == "bends" and sum(map(len, kappa)) * _STEP_M < length_m:
        bend = rng.choice([-1.0, 1.0]) / rng.uniform(6.0, 15.0)
        angle = rng.uniform(0.4, 1.6)
        kappa += [_clothoid(bend, angle / abs(bend)), np.zeros(round(rng.uniform(3.0, 15.0) / _STEP_M))]
    kappa += [np.zeros(round(10.0 / _STEP_M))] if kappa else [np.zeros(round(length_m / _STEP_M))]
    curvature = np.concatenate(kappa)
    if kind == "straight":
        # A driver does not keep a straight line, either.
        s = _STEP_M * np.arange(len(curvature))
        curvature = curvature + 0.003 * np.sin(2.0 * math.pi * s / 30.0)
    yaw = np.concatenate(([0.0], np.cumsum(curvature) * _STEP_M))
    s = _STEP_M * np.arange(len(yaw))
    wave_m = rng.uniform(20.0, 50.0)
    speed = top_mps * (0.7 + 0.3 * np.cos(2.0 * math.pi * s / wave_m))
    speed = np.minimum(speed, np.sqrt(2.0 * np.minimum(s, s[-1] - s) + 0.02))
    speed = np.minimum(speed, np.sqrt(2.0 / np.maximum(np.abs(np.append(curvature, 0.0)), 1e-3)))
    time = np.concatenate(([0.0], np.cumsum(_STEP_M / (0.5 * (speed[1:] + speed[:-1])))))
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    x = np.concatenate(([0.0], np.cumsum(np.cos(middle)) * _STEP_M))
    y = np.concatenate(([0.0], np.cumsum(np.sin(middle)) * _STEP_M))
    # It stands before it drives; brakes are not pulled in a step.
    t = _STEP_S * np.arange(math.floor(duration_s / _STEP_S))
    width = round(0.5 / _STEP_S)
    way = np.interp(t - _STANDS_S, time, s)
    for _ in range(2):
        way = np.convolve(np.pad(way, width, mode="edge"), np.ones(width) / width, "same")[width:-width]
    return np.column_stack((t, *(np.interp(way, s, column) for column in (x, y, yaw))))


def _clothoid(bend: float, length_m: float) -> Array:
    """(n,) curvatures that rise and fall over a quarter of the bend each."""
    share = np.linspace(0.0, 1.0, max(8, round(1.25 * length_m / _STEP_M)))
    curvature: Array = bend * np.clip(np.minimum(share, 1.0 - share) * 4.0, 0.0, 1.0)
    return curvature


def _street(places: Array, rng: np.random.Generator) -> RoadMap:
    """A lane along the drive, and houses that stand beside all of it."""
    lengths = np.hypot(*np.diff(places, axis=0).T)
    s = np.concatenate(([0.0], np.cumsum(lengths)))
    if s[-1] < 10.0:
        places, s = np.array([[-20.0, 0.0], [20.0, 0.0]]), np.array([0.0, 40.0])
    at = np.linspace(0.0, s[-1], math.ceil(s[-1] / _LANE_STEP_M))
    points = np.column_stack([np.interp(at, s, column) for column in places.T])
    lane = Lane("way", "road", tuple((float(x), float(y)) for x, y in points), 4.0, 5.0, False, ("way",))
    found: list[Building] = []
    low, high = points.min(axis=0) - 14.0, points.max(axis=0) + 14.0
    for side in (True, False):
        found += houses(0.5 * (low + high), 0.5 * (high - low), rng, inside=side)
    # And between the bends, where there is room.
    for _ in range(400):
        middle = rng.uniform(low, high)
        reach = float(np.hypot(*(points - middle).T).min())
        others = [float(np.hypot(*(np.mean(b.outline, axis=0) - middle))) for b in found]
        if reach > 10.0 and min(others, default=99.0) > 12.0:
            found += [_shed(middle, rng)]
    return RoadMap("way", "Way", Origin(0.0, 0.0), (lane,), (), (), (), tuple(found))


def _shed(middle: Array, rng: np.random.Generator) -> Building:
    angle, half = rng.uniform(0.0, math.pi), rng.uniform(1.5, 4.0, 2)
    cos, sin = math.cos(angle), math.sin(angle)
    corners = [
        middle + np.array([cos * u * half[0] - sin * v * half[1], sin * u * half[0] + cos * v * half[1]])
        for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return Building(tuple((float(x), float(y)) for x, y in corners), float(rng.uniform(3.0, 9.0)))
