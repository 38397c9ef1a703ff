"""Localization with a planar laser along a way: the survey's map, this day's scans and their worker."""

import math
import time
from collections import deque
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
from benchmarks.mapping.campus_drive import DrivenBody, Trace, Traffic
from benchmarks.mapping.receiver import view_of
from campusloop.scenes.laser_survey import LaserSurvey
from contract.geometry import Array, Pose2, compose, inverse, wrap_angle
from contract.roads.model import RoadMap
from simulator.sensors.gnss import CampusReceiver, GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu
from simulator.sensors.lidars.driver import planar_points
from simulator.sensors.lidars.mounts import planar_mount
from simulator.sensors.lidars.planar_scanner import PlanarScanner
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.shapes import truck
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.sky import Sky
from vehicle_agent.config import Profile
from vehicle_agent.localization.laser.pose_arrays import composed
from vehicle_agent.localization.odometry_ekf import YAW, X, Y
from vehicle_agent.localization.planar_map.matcher import PlanarMatcher
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization, ScanMapState
from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.signals import GnssFix, ImuSample, Navigation, ScanPose, VehicleMotion
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud
from workshop.laser_mapping.mapping import NoProgress
from workshop.laser_mapping.site_mapping import SiteMap, SiteMappingParams, map_site

# The scene's seed: of everything that all days have in common.
SCENE_SEED = 1
# The map is made on a day of its own: other noise, other traffic, other parked cars, another receiver.
MAP_DAY = 9_000
# Of the mirror's turns, 50 a second, every fifth is used.
SCAN_TICKS = 5
# From the end of a scan to its pose: the worker's time, and the mailboxes.
_DELAY_TICKS = 3
# A kidnapped estimate is somewhere else, as sure as before.
_KIDNAP_FROM_TICK, _KIDNAP_EVERY_TICKS = 3_000, 2_000
_KIDNAP_M, _KIDNAP_RAD = (1.0, 8.0), 0.3


@dataclass(frozen=True, slots=True, eq=False)
class PlanarConditions:
    """receiver: as for the other rows; changes: of the world since the map's day; kidnaps: now and then.

    trucks  the other vehicles on the road are trucks, which hide what is behind them
    """

    name: str
    receiver: Conditions
    changes: WorldChanges
    trucks: bool = False
    kidnaps: bool = False


_OUTAGES = Conditions("300 m outages", outage_m=300.0, outage_every_m=600.0)
PLANAR_CONDITIONS = (
    PlanarConditions("open sky", Conditions("open sky", open_sky=True), WorldChanges(seed=76)),
    PlanarConditions("300 m outages", _OUTAGES, WorldChanges(seed=77)),
    PlanarConditions(
        "300 m outages, trucks",
        _OUTAGES,
        WorldChanges(seed=78, parked_ratio=0.5, trucks_ratio=0.5),
        trucks=True,
    ),
    PlanarConditions(
        "300 m outages, changed world",
        _OUTAGES,
        WorldChanges(
            seed=79, buildings_altered_ratio=0.15, trees_felled_ratio=0.1, parked_ratio=0.5, trucks_ratio=0.4,
            works=20,
        ),
    ),
    PlanarConditions("no GNSS, kidnapped", Conditions("no GNSS"), WorldChanges(seed=80), kidnaps=True),
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class PlanarDrive:
    """drive: as for the other rows; scan_cpu_s (k,): of the worker; agreement (k,), lost (n,) at each tick.

    kidnaps: of each, whether the vehicle was slow within 2 s, and right again within 20 s
    """

    drive: Drive
    scan_cpu_s: Array
    agreement: Array
    lost: Array
    kidnaps: tuple[bool, ...]
    scan_error_m: Array
    scan_nees: Array


class LaserDrive:
    """The scans of one drive, one every 0.1 s, as the scanner's driver on a vehicle hands them over."""

    def __init__(
        self, scene: StaticScene, drive: Trace, profile: Profile, seed: int, *, trucks: bool = False
    ) -> None:
        rng = np.random.default_rng([seed, 13])
        self._drive, self._rng = drive, rng
        self._poses = DrivenBody(scene.ground, drive, rng, profile.body.wheelbase_m).poses
        self._mount = planar_mount(profile.planar_scanner)
        self._scanner = PlanarScanner(self._mount, scene, rng)
        self._traffic = Traffic(drive, scene, rng, truck() if trucks else None)
        self.scans = (len(drive) - SCAN_TICKS) // SCAN_TICKS

    def scan(self, number: int) -> PointCloud:
        """Of a turn that begins at tick 5 * number; in order, as its noise is drawn."""
        tick, drive = SCAN_TICKS * number, self._drive
        scan = self._scanner.scan(self._poses, STEP_NS * tick, self._traffic.bodies(tick))
        speed, turn = self._rng.standard_normal(2).tolist()
        speed_mps = float(drive.speed_mps[tick]) + WHEEL_NOISE_MPS * speed
        yaw_rate_radps = float(drive.yaw_rate_radps[tick]) + IMU.yaw_rate_std_radps * turn
        points, intensities = planar_points(
            scan, self._mount.T_base_sensor, STEP_NS, speed_mps, yaw_rate_radps
        )
        return point_cloud(stamp_ns(tick + 1), points, intensities)


class SensedDrive:
    """What receiver, wheels and gyroscope say of a drive, tick by tick. Everything random is of the seed."""

    def __init__(self, way: Trace, road_map: RoadMap, conditions: Conditions, seed: int) -> None:
        rng = np.random.default_rng([seed, 7])
        self._way, self._conditions, self._rng = way, conditions, rng
        self.receiver = (
            GnssReceiver(road_map.origin, GnssNoise(), rng)
            if conditions.open_sky
            else CampusReceiver(road_map.origin, GnssNoise(), Sky(road_map.buildings, rng), rng)
        )
        self._imu = Imu(IMU, rng)
        self._wheel_scale = 1.0 + float(rng.standard_normal()) * WHEEL_SCALE_STD

    def tick(self, tick: int, *, is_silent: bool = False) -> tuple[VehicleMotion, list[GnssFix | ImuSample]]:
        # Time begins with the first tick after 0, which means never.
        now_ns, truth = stamp_ns(tick), view_of(self._way, tick)
        self.receiver.silent = is_silent or is_outage(truth.odometer_m, self._conditions)
        wheel_mps = 0.0
        if truth.speed_mps > 0.0:
            noisy_mps = truth.speed_mps * self._wheel_scale
            noisy_mps += float(self._rng.standard_normal()) * WHEEL_NOISE_MPS
            wheel_mps = WHEEL_STEP_MPS * round(noisy_mps / WHEEL_STEP_MPS)
        fix = self.receiver.fix(now_ns, truth)
        items: list[GnssFix | ImuSample] = [self._imu.sample(now_ns, truth)]
        items += [fix] if fix is not None else []
        return VehicleMotion(now_ns, wheel_mps, 0.0, 0.0, 0.0, True, False, True, 1.0), items


def stamp_ns(tick: int) -> int:
    """Of a tick's measurements. The vehicle's clock is a tick ahead of the scene's."""
    return STEP_NS * (tick + 1)


def tiles_of_way(road_map: RoadMap, way: Trace, profile: Profile, seed: int) -> SiteMap:
    """The map that the workshop makes of a survey of this way, on the map's day."""
    at = np.searchsorted(way.odometer_m, np.arange(0.0, way.odometer_m[-1]))
    points = np.column_stack((way.x_m[at], way.y_m[at]))
    log, fixes = LaserSurvey(road_map, profile, points, SCENE_SEED, MAP_DAY + seed).record(
        lambda seconds: None
    )
    return map_site(log, fixes, SiteMappingParams(), NoProgress())


@dataclass(frozen=True, slots=True, eq=False)
class RecordedDay:
    """What a vehicle's sensors said on one drive, tick by tick; scans: of every fifth tick."""

    way: Trace
    conditions: PlanarConditions
    motions: list[VehicleMotion]
    navigation: list[tuple[GnssFix | ImuSample, ...]]
    scans: list[PointCloud]


def recorded_day(
    way: Trace, road_map: RoadMap, profile: Profile, conditions: PlanarConditions, seed: int
) -> RecordedDay:
    """Everything random is drawn from the seed."""
    sensed = SensedDrive(way, road_map, conditions.receiver, seed)
    scene = StaticScene(road_map, SCENE_SEED, conditions.changes)
    laser = LaserDrive(scene, way, profile, seed, trucks=conditions.trucks)
    motions, navigation, scans = [], [], []
    for tick in range(SCAN_TICKS * laser.scans):
        # Learned under the sky; the receiver is then silent.
        is_silent = conditions.kidnaps and tick > _KIDNAP_FROM_TICK
        motion, items = sensed.tick(tick, is_silent=is_silent)
        motions.append(motion)
        navigation.append(tuple(items))
        if tick % SCAN_TICKS == 0:
            scans.append(laser.scan(tick // SCAN_TICKS))
    return RecordedDay(way, conditions, motions, navigation, scans)


def planar_drive(
    day: RecordedDay, room: ScanMapLocalization, matcher: PlanarMatcher | None, seed: int
) -> PlanarDrive:
    """matcher None: with GNSS, wheels and gyroscope alone."""
    worker = None if matcher is None else LocalizationWorker(matcher)
    rng = np.random.default_rng([seed, 17])
    due: deque[tuple[int, ScanPose]] = deque()
    state, rows, cpu_s, agreement, kidnapped = room.initial(), [], [], [], []
    scan_rows = []
    for tick, (motion, measured) in enumerate(zip(day.motions, day.navigation, strict=True)):
        now_ns, truth = stamp_ns(tick), view_of(day.way, tick)
        items: list[Navigation] = [*measured]
        while due and due[0][0] <= tick:
            items.append(due.popleft()[1])
        if day.conditions.kidnaps and tick > _KIDNAP_FROM_TICK and tick % _KIDNAP_EVERY_TICKS == 0:
            state = _kidnapped(state, matcher, rng)
            kidnapped.append(tick)
        begun_s = time.process_time()
        ego, state = room.step(state, motion, tuple(items), now_ns)
        spent_s = time.process_time() - begun_s
        # A turn of the mirror that began at the last tick is over at this one.
        for job in room.jobs(state) if worker is not None else ():
            worker.take(job)
        if worker is not None and tick % SCAN_TICKS == 1:
            cloud = day.scans[tick // SCAN_TICKS]
            if worker.is_ready(cloud.stamp_ns):
                begun_s = time.process_time()
                pose = worker.answer(cloud)
                cpu_s.append(time.process_time() - begun_s)
                if isinstance(pose, ScanPose):
                    agreement.append(pose.agreement)
                    due.append((tick + _DELAY_TICKS, pose))
                    scan_rows.append(_scan_row(day.way, tick, pose))
        error = np.array((ego.pose_map.x_m - truth.pose_map.x_m, ego.pose_map.y_m - truth.pose_map.y_m))
        known = state.fix_stamp_ns > 0
        nees = float(error @ np.linalg.inv(state.covariance[:2, :2]) @ error) if known else math.nan
        rows.append(
            (
                float(np.hypot(*error)) if known else math.nan,
                ego.position_std_m,
                nees,
                spent_s,
                ego.valid and ego.position_std_m <= 0.3,
                False,
                room.is_lost(state),
            )
        )
    table = np.array(rows, dtype=np.float64)
    drive = Drive(*(table[:, i] for i in range(6)))
    scans = np.array(scan_rows, dtype=np.float64).reshape(-1, 2)
    return PlanarDrive(
        drive, np.array(cpu_s), np.array(agreement), table[:, 6],
        tuple(_is_found(drive, tick) for tick in kidnapped if tick + 1_000 < len(table)),
        scans[:, 0], scans[:, 1],
    )  # fmt: skip


def _scan_row(way: Trace, tick: int, pose: ScanPose) -> tuple[float, float]:
    """(error, squared error over the stated covariance) of one scan's place."""
    error = np.array([pose.pose_map.x_m - way.x_m[tick], pose.pose_map.y_m - way.y_m[tick]])
    return float(np.hypot(*error)), float(error @ np.linalg.inv(pose.covariance[:2, :2]) @ error)


def _kidnapped(state: ScanMapState, matcher: PlanarMatcher | None, rng: np.random.Generator) -> ScanMapState:
    """The filter's mean and the particles are moved alike: nothing notices but the scans."""
    angle, size_m = float(rng.uniform(0.0, 2.0 * math.pi)), float(rng.uniform(*_KIDNAP_M))
    turn_rad = float(rng.uniform(-_KIDNAP_RAD, _KIDNAP_RAD))
    mean = state.filter.mean.copy()
    before = Pose2(float(mean[X]), float(mean[Y]), float(mean[YAW]))
    after = Pose2(
        before.x_m + size_m * math.cos(angle),
        before.y_m + size_m * math.sin(angle),
        wrap_angle(before.yaw_rad + turn_rad),
    )
    mean[X], mean[Y], mean[YAW] = after.x_m, after.y_m, after.yaw_rad
    if matcher is not None and matcher.localizer.tracked is not None:
        tracked = matcher.localizer.tracked
        poses = composed(_array(compose(after, inverse(before))), tracked.state.poses)
        tracked.state = msgspec.structs.replace(tracked.state, poses=poses)
    return msgspec.structs.replace(state, filter=msgspec.structs.replace(state.filter, mean=mean))


def _is_found(drive: Drive, tick: int) -> bool:
    """Whether the vehicle was slow within 2 s, and right again within 20 s."""
    error_m, drivable = drive.error_m[tick : tick + 1_000], drive.drivable[tick : tick + 1_000]
    right = np.flatnonzero(error_m < 0.3)
    if len(right) == 0:
        return False
    return bool((drivable[: int(right[0])] > 0.0).sum() <= 100)


def _array(pose: Pose2) -> Array:
    return np.array([pose.x_m, pose.y_m, pose.yaw_rad])
