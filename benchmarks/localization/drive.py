"""One vehicle's localization along a way: its receiver, its odometry's errors, and what it says of itself."""

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from contract.geometry import Array
from contract.roads.model import RoadMap
from simulator.sensors.gnss import CampusReceiver, GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu, ImuNoise
from simulator.sensors.sky import Sky
from simulator.vehicle.plant import PlantView
from vehicle_agent.signals import GnssFix, VehicleMotion

STEP_NS = 20_000_000
# Of tyres as they are worn and loaded.
WHEEL_SCALE_STD = 0.01
WHEEL_NOISE_MPS = 0.02
WHEEL_STEP_MPS = 0.01
IMU = ImuNoise(yaw_rate_bias_std_radps=0.002, yaw_rate_walk_radps=1e-5, yaw_rate_scale_std=0.003)


@dataclass(frozen=True, slots=True)
class Conditions:
    """outage_m of every outage_every_m without a fix; jumps: the receiver is metres off, now and then."""

    name: str
    open_sky: bool = False
    outage_m: float = 0.0
    outage_every_m: float = 1000.0
    jumps: bool = False


CONDITIONS = (
    Conditions("open sky", open_sky=True),
    Conditions("between buildings"),
    Conditions("100 m outages", outage_m=100.0),
    Conditions("300 m outages", outage_m=300.0),
    Conditions("jumps", jumps=True),
)


@dataclass(frozen=True, slots=True)
class Drive:
    """Of each tick, arrays (n,).

    error_m, std_m  distance from the truth, and the stated deviation; nees: squared error over the covariance
    cpu_s           of the room; wrong: the receiver was shifted
    drivable        the pose is valid and its deviation allows full speed
    """

    error_m: Array
    std_m: Array
    nees: Array
    cpu_s: Array
    drivable: Array
    wrong: Array


def drive(
    views: Iterable[PlantView], room: Any, road_map: RoadMap, conditions: Conditions, seed: int
) -> Drive:
    """room: the localization of a stack. Everything random is drawn from the seed."""
    rng = np.random.default_rng([seed, 7])
    receiver = (
        GnssReceiver(road_map.origin, GnssNoise(), rng)
        if conditions.open_sky
        else CampusReceiver(road_map.origin, GnssNoise(), Sky(road_map.buildings, rng), rng)
    )
    imu, shifts = Imu(IMU, rng), Shifts(rng)
    wheel_scale = 1.0 + float(rng.standard_normal()) * WHEEL_SCALE_STD
    state, now_ns, rows = room.initial(), 0, []
    for truth in views:
        now_ns += STEP_NS
        receiver.silent = is_outage(truth.odometer_m, conditions)
        receiver.shift_m = shifts.at(truth.odometer_m) if conditions.jumps else (0.0, 0.0)
        wheel_mps = 0.0
        if truth.speed_mps > 0.0:
            noisy_mps = truth.speed_mps * wheel_scale + float(rng.standard_normal()) * WHEEL_NOISE_MPS
            wheel_mps = WHEEL_STEP_MPS * round(noisy_mps / WHEEL_STEP_MPS)
        motion = VehicleMotion(now_ns, wheel_mps, 0.0, 0.0, 0.0, True, False, True, 1.0)
        fix: GnssFix | None = receiver.fix(now_ns, truth)
        items = (imu.sample(now_ns, truth),) if fix is None else (imu.sample(now_ns, truth), fix)
        begun_s = time.process_time()
        ego, state = room.step(state, motion, items, now_ns)
        cpu_s = time.process_time() - begun_s
        error = np.array(
            (ego.pose_map.x_m - truth.pose_map.x_m, ego.pose_map.y_m - truth.pose_map.y_m), dtype=np.float64
        )
        known = state.fix_stamp_ns > 0
        nees = float(error @ np.linalg.inv(state.covariance[:2, :2]) @ error) if known else math.nan
        drivable = ego.valid and ego.position_std_m <= 0.3
        rows.append(
            (
                float(np.hypot(*error)) if known else math.nan,
                ego.position_std_m,
                nees,
                cpu_s,
                drivable,
                receiver.shift_m != (0.0, 0.0),
            )
        )
    table = np.array(rows, dtype=np.float64)
    return Drive(*(table[:, i] for i in range(6)))


def is_outage(odometer_m: float, conditions: Conditions) -> bool:
    """The last metres of each kilometre or so: the filter has learned its sensors by then."""
    if conditions.outage_m == 0.0:
        return False
    return odometer_m % conditions.outage_every_m > conditions.outage_every_m - conditions.outage_m


class Shifts:
    """Jumps of a receiver that it does not notice: 1 to 30 m for 3 to 60 m of the way, every 200 m or so."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._next_m, self._until_m = 150.0, 150.0
        self._shift = (0.0, 0.0)

    def at(self, odometer_m: float) -> tuple[float, float]:
        if odometer_m >= self._next_m:
            angle = float(self._rng.uniform(0.0, 2.0 * math.pi))
            size_m = float(np.exp(self._rng.uniform(0.0, math.log(30.0))))
            self._shift = (size_m * math.cos(angle), size_m * math.sin(angle))
            self._until_m = odometer_m + float(self._rng.uniform(3.0, 60.0))
            self._next_m = self._until_m + float(self._rng.uniform(100.0, 300.0))
        return self._shift if odometer_m < self._until_m else (0.0, 0.0)
