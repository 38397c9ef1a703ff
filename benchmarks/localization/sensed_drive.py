"""What drives with scans share: receiver, wheels and gyroscope, kidnappings, and the rows of their ticks."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from benchmarks.localization.drive import (
    IMU,
    STEP_NS,
    WHEEL_NOISE_MPS,
    WHEEL_SCALE_STD,
    WHEEL_STEP_MPS,
    Conditions,
    Drive,
    is_outage,
)
from benchmarks.mapping.campus_drive import Trace
from benchmarks.mapping.receiver import view_of
from contract.geometry import Array, Pose2, wrap_angle
from contract.roads.model import RoadMap
from simulator.sensors.gnss import CampusReceiver, GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu
from simulator.sensors.sky import Sky
from vehicle_agent.localization.odometry_ekf import YAW, X, Y
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization, ScanMapState
from vehicle_agent.signals import Ego, GnssFix, ImuSample, VehicleMotion

# The scene's seed: of everything that all days have in common.
SCENE_SEED = 1
# The map is made on a day of its own: other noise, other traffic, other parked cars, another receiver.
MAP_DAY = 9_000
# Of the turns of a scanner, ten a second are used.
SCAN_TICKS = 5
# Until the filter knows its sensors; the receiver of kidnapped vehicles is silent from then on.
LEARNED_TICKS = 3_000
# A vehicle that says within this time that it is not sure has noticed; in that one it has to be right again.
_NOTICED_TICKS, _RIGHT_TICKS = 100, 1_000
_RIGHT_M = 0.3


@dataclass(frozen=True, slots=True)
class Kidnapping:
    """The estimate is somewhere else, as sure as before, every so many ticks: the way's length is drawn
    evenly on a logarithmic scale, and so many turn by any angle, the others by turn_rad at most."""

    every_ticks: int
    size_m: tuple[float, float]
    turn_rad: float = 0.3
    any_turn_ratio: float = 0.0

    def drawn(self, pose: Pose2, rng: np.random.Generator) -> Pose2:
        angle = float(rng.uniform(0.0, 2.0 * math.pi))
        size_m = float(np.exp(rng.uniform(*np.log(self.size_m))))
        most = math.pi if float(rng.uniform()) < self.any_turn_ratio else self.turn_rad
        return Pose2(
            pose.x_m + size_m * math.cos(angle),
            pose.y_m + size_m * math.sin(angle),
            wrap_angle(pose.yaw_rad + float(rng.uniform(-most, most))),
        )


@dataclass(frozen=True, slots=True)
class Kidnapped:
    """Whether the vehicle was slow, or right, within 2 s of one; and when it was right, s, or never."""

    is_noticed: bool
    right_s: float


class SensedDrive:
    """What receiver, wheels and gyroscope say of a drive, tick by tick. Everything random is of the seed."""

    def __init__(self, way: Trace, road_map: RoadMap, conditions: Conditions, seed: int) -> None:
        rng = np.random.default_rng([seed, 7])
        self._way, self._conditions, self._rng = way, conditions, rng
        self._receiver = (
            GnssReceiver(road_map.origin, GnssNoise(), rng)
            if conditions.open_sky
            else CampusReceiver(road_map.origin, GnssNoise(), Sky(road_map.buildings, rng), rng)
        )
        self._imu = Imu(IMU, rng)
        self._wheel_scale = 1.0 + float(rng.standard_normal()) * WHEEL_SCALE_STD

    def tick(self, tick: int, *, is_silent: bool = False) -> tuple[VehicleMotion, list[GnssFix | ImuSample]]:
        """is_silent: the receiver has no fix."""
        # Time begins with the first tick after 0, which means never.
        now_ns, truth = stamp_ns(tick), view_of(self._way, tick)
        self._receiver.silent = is_silent or is_outage(truth.odometer_m, self._conditions)
        wheel_mps = 0.0
        if truth.speed_mps > 0.0:
            noisy_mps = truth.speed_mps * self._wheel_scale
            noisy_mps += float(self._rng.standard_normal()) * WHEEL_NOISE_MPS
            wheel_mps = WHEEL_STEP_MPS * round(noisy_mps / WHEEL_STEP_MPS)
        fix = self._receiver.fix(now_ns, truth)
        items: list[GnssFix | ImuSample] = [self._imu.sample(now_ns, truth)]
        items += [fix] if fix is not None else []
        return VehicleMotion(now_ns, wheel_mps, 0.0, 0.0, 0.0, True, False, True, 1.0), items


class DriveRows:
    """Each tick's errors and what the vehicle says of itself."""

    def __init__(self, way: Trace) -> None:
        self._way = way
        self._rows: list[tuple[float, ...]] = []

    def add(
        self, tick: int, room: ScanMapLocalization, state: ScanMapState, ego: Ego, spent_s: float
    ) -> None:
        way = self._way
        error = np.array((ego.pose_map.x_m - way.x_m[tick], ego.pose_map.y_m - way.y_m[tick]))
        known = state.fix_stamp_ns > 0
        nees = float(error @ np.linalg.inv(state.covariance[:2, :2]) @ error) if known else math.nan
        error_m = float(np.hypot(*error)) if known else math.nan
        drivable = ego.valid and ego.position_std_m <= 0.3
        self._rows.append(
            (error_m, ego.position_std_m, nees, spent_s, drivable, False, room.is_lost(state), state.doubt)
        )

    def drive(self) -> tuple[Drive, Array, Array]:
        """(as for drives without scans, lost (n,), doubt (n,))"""
        table = np.array(self._rows, dtype=np.float64)
        return Drive(*(table[:, i] for i in range(6))), table[:, 6], table[:, 7]

    def is_right(self) -> bool:
        """At the last tick."""
        return self._rows[-1][0] < _RIGHT_M


def stamp_ns(tick: int) -> int:
    """Of a tick's measurements. The vehicle's clock is a tick ahead of the scene's."""
    return STEP_NS * (tick + 1)


def pose_of(state: ScanMapState) -> Pose2:
    mean = state.filter.mean
    return Pose2(float(mean[X]), float(mean[Y]), float(mean[YAW]))


def placed_at(state: ScanMapState, pose: Pose2) -> ScanMapState:
    """The state with its pose somewhere else, and as sure of it as before."""
    mean = state.filter.mean.copy()
    mean[X], mean[Y], mean[YAW] = pose.x_m, pose.y_m, pose.yaw_rad
    return msgspec.structs.replace(state, filter=msgspec.structs.replace(state.filter, mean=mean))


def kidnapped(drive: Drive, ticks: list[int]) -> tuple[Kidnapped, ...]:
    """What became of kidnappings at these ticks; those shortly before the drive's end are left out."""
    found = []
    for tick in ticks:
        if tick + _RIGHT_TICKS >= len(drive.error_m):
            continue
        error_m = drive.error_m[tick : tick + _RIGHT_TICKS]
        slow = np.flatnonzero(drive.drivable[tick : tick + _RIGHT_TICKS] == 0.0)
        right = np.flatnonzero(error_m < _RIGHT_M)
        first_slow = int(slow[0]) if len(slow) else _RIGHT_TICKS
        first_right = int(right[0]) if len(right) else _RIGHT_TICKS
        noticed = min(first_slow, first_right) <= _NOTICED_TICKS
        right_s = 1e-9 * STEP_NS * first_right if first_right < _RIGHT_TICKS else math.inf
        found.append(Kidnapped(noticed, right_s))
    return tuple(found)
