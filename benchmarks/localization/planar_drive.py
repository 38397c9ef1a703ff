"""Localization with a planar laser along a way: the survey's map, this day's scans and their worker."""

import dataclasses
import time
from collections import deque
from dataclasses import dataclass

import msgspec
import numpy as np

from benchmarks.localization.drive import IMU, STEP_NS, WHEEL_NOISE_MPS, Conditions, Drive
from benchmarks.localization.sensed_drive import (
    LEARNED_TICKS,
    MAP_DAY,
    SCAN_TICKS,
    SCENE_SEED,
    DriveRows,
    Kidnapped,
    Kidnapping,
    SensedDrive,
    kidnapped,
    placed_at,
    pose_of,
    stamp_ns,
)
from benchmarks.mapping.campus_drive import DrivenBody, Trace, Traffic
from campusloop.scenes.laser_survey import LaserSurvey
from contract.geometry import Array, Pose2, compose, inverse
from contract.roads.model import RoadMap
from simulator.sensors.lidars.driver import planar_points
from simulator.sensors.lidars.mounts import planar_mount
from simulator.sensors.lidars.planar_scanner import PlanarScanner
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.shapes import truck
from simulator.sensors.scene.static_scene import StaticScene
from vehicle_agent.config import Profile
from vehicle_agent.localization.laser.pose_arrays import composed
from vehicle_agent.localization.planar_map.matcher import PlanarMatcher
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization
from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.signals import GnssFix, ImuSample, Navigation, ScanPose, VehicleMotion
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud
from workshop.laser_mapping.mapping import NoProgress
from workshop.laser_mapping.site_mapping import SiteMap, SiteMappingParams, map_site

# From the end of a scan to its pose: the worker's time, and the mailboxes.
_DELAY_TICKS = 3
# A third of the kidnappings turn the vehicle by any angle.
_KIDNAPPING = Kidnapping(1_100, (2.0, 30.0), any_turn_ratio=0.3)


@dataclass(frozen=True, slots=True, eq=False)
class PlanarConditions:
    """receiver: as for the other rows; changes: of the world since the map's day; kidnapping: now and then.

    trucks  the other vehicles on the road are trucks, which hide what is behind them
    """

    name: str
    receiver: Conditions
    changes: WorldChanges
    trucks: bool = False
    kidnapping: Kidnapping | None = None

    def on_day(self, day: int) -> "PlanarConditions":
        """The same with changes of another seed."""
        changes = dataclasses.replace(self.changes, seed=self.changes.seed + 1000 * day)
        return dataclasses.replace(self, changes=changes)


_OUTAGES = Conditions("300 m outages", outage_m=300.0, outage_every_m=600.0)
_MOSTLY_SILENT = Conditions("450 m outages", outage_m=450.0, outage_every_m=600.0)
_SILENT = Conditions("no GNSS")
_CHANGED = WorldChanges(
    seed=79, buildings_altered_ratio=0.15, trees_felled_ratio=0.1, parked_ratio=0.5, trucks_ratio=0.4,
    works=20,
)  # fmt: skip
PLANAR_CONDITIONS = (
    PlanarConditions("open sky", Conditions("open sky", open_sky=True), WorldChanges(seed=76)),
    PlanarConditions("300 m outages", _OUTAGES, WorldChanges(seed=77)),
    PlanarConditions(
        "300 m outages, trucks",
        _OUTAGES,
        WorldChanges(seed=78, parked_ratio=0.5, trucks_ratio=0.5),
        trucks=True,
    ),
    PlanarConditions("300 m outages, changed world", _OUTAGES, _CHANGED),
    PlanarConditions("no GNSS, kidnapped", _SILENT, WorldChanges(seed=80), kidnapping=_KIDNAPPING),
    PlanarConditions("no GNSS, changed world, kidnapped", _SILENT, _CHANGED, kidnapping=_KIDNAPPING),
)
# Of long tests for false alarms: GNSS, which silences alarms, is there for a quarter of the way.
PLANAR_DAY = PlanarConditions("450 m outages, changed world, further day", _MOSTLY_SILENT, _CHANGED)


@dataclass(frozen=True, slots=True, eq=False)
class PlanarDrive:
    """drive: as for the other rows; scan_cpu_s (k,): of the worker; agreement (k,), lost (n,) at each tick.

    kidnaps: what became of each
    """

    drive: Drive
    scan_cpu_s: Array
    agreement: Array
    lost: Array
    kidnaps: tuple[Kidnapped, ...]
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
        is_silent = conditions.kidnapping is not None and tick > LEARNED_TICKS
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
    state, table, cpu_s, agreement, ticks = room.initial(), DriveRows(day.way), [], [], []
    scan_rows, kidnapping = [], day.conditions.kidnapping
    for tick, (motion, measured) in enumerate(zip(day.motions, day.navigation, strict=True)):
        items: list[Navigation] = [*measured]
        while due and due[0][0] <= tick:
            items.append(due.popleft()[1])
        is_time = kidnapping is not None and tick > LEARNED_TICKS and tick % kidnapping.every_ticks == 0
        if kidnapping is not None and is_time and table.is_right():
            before = pose_of(state)
            after = kidnapping.drawn(before, rng)
            state = placed_at(state, after)
            _move_particles(matcher, before, after)
            ticks.append(tick)
        begun_s = time.process_time()
        ego, state = room.step(state, motion, tuple(items), stamp_ns(tick))
        table.add(tick, room, state, ego, time.process_time() - begun_s)
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
    drive, lost, _ = table.drive()
    scans = np.array(scan_rows, dtype=np.float64).reshape(-1, 2)
    return PlanarDrive(
        drive, np.array(cpu_s), np.array(agreement), lost, kidnapped(drive, ticks), scans[:, 0], scans[:, 1]
    )


def _scan_row(way: Trace, tick: int, pose: ScanPose) -> tuple[float, float]:
    """(error, squared error over the stated covariance) of one scan's place."""
    error = np.array([pose.pose_map.x_m - way.x_m[tick], pose.pose_map.y_m - way.y_m[tick]])
    return float(np.hypot(*error)), float(error @ np.linalg.inv(pose.covariance[:2, :2]) @ error)


def _move_particles(matcher: PlanarMatcher | None, before: Pose2, after: Pose2) -> None:
    """The particles move as the filter's pose does: nothing notices but the scans."""
    if matcher is None or matcher.localizer.tracked is None:
        return
    tracked = matcher.localizer.tracked
    poses = composed(_array(compose(after, inverse(before))), tracked.state.poses)
    tracked.state = msgspec.structs.replace(tracked.state, poses=poses)


def _array(pose: Pose2) -> Array:
    return np.array([pose.x_m, pose.y_m, pose.yaw_rad])
