"""Scan-to-map localization along a way: the map of another day's drive, this day's scans and their worker."""

import dataclasses
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
from benchmarks.mapping.campus_drive import MOUNT_M, SCAN_TICKS, LidarDrive, Trace
from benchmarks.mapping.receiver import fixes_of, view_of
from contract.geometry import Array, wrap_angle
from contract.point_map.tiles import Surfels
from contract.roads.model import RoadMap
from simulator.sensors.gnss import CampusReceiver, GnssNoise
from simulator.sensors.imu import Imu
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.sky import Sky
from vehicle_agent.localization.odometry_ekf import YAW, X, Y
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization, ScanMapState
from vehicle_agent.localization.scan_map.localizer import ScanLocalizer
from vehicle_agent.signals import GnssFix, ImuSample, ScanPose, VehicleMotion
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.cloud_mapping.map_folder import TILE_M, tiles_of
from workshop.cloud_mapping.mapping import CloudMappingParams, NoProgress, map_scans

# The scene's seed: of everything that both days have in common.
SCENE_SEED = 1
# The map is made on a day of its own: other noise, other traffic, other parked cars, another receiver.
MAP_DAY = 9_000
# From the end of a scan to its pose: the worker's time, and the mailboxes.
_DELAY_TICKS = 5
_PARAMS = CloudMappingParams(lever_sensor_m=(-MOUNT_M[0], -MOUNT_M[1], -MOUNT_M[2]))
# A kidnapped estimate is somewhere else, as sure as before.
_KIDNAP_FROM_TICK, _KIDNAP_EVERY_TICKS = 3_000, 1_100
_KIDNAP_M, _KIDNAP_RAD = (1.0, 8.0), 0.3


@dataclass(frozen=True, slots=True, eq=False)
class ScanConditions:
    """One row: receiver, as for the other rows; changes of the world since the map's day; the way driven.

    lane   "same" as on the map's day, "other" to the left of it, or "opposite": the other one, and back
    kidnaps  now and then, without GNSS
    """

    name: str
    receiver: Conditions
    changes: WorldChanges
    lane: str = "same"
    kidnaps: bool = False

    def on_day(self, day: int) -> "ScanConditions":
        """The same with changes of another seed."""
        changes = dataclasses.replace(self.changes, seed=self.changes.seed + 1000 * day)
        return dataclasses.replace(self, changes=changes)


_OUTAGES = Conditions("300 m outages", outage_m=300.0, outage_every_m=600.0)
_SILENT = Conditions("no GNSS")
_MOSTLY_SILENT = Conditions("450 m outages", outage_m=450.0, outage_every_m=600.0)
_CHANGED = WorldChanges(
    seed=78,
    buildings_altered_ratio=0.15,
    trees_felled_ratio=0.1,
    parked_ratio=0.5,
    trucks_ratio=0.4,
    works=20,
)
_TRUCKS = WorldChanges(
    seed=80,
    buildings_altered_ratio=0.15,
    trees_felled_ratio=0.2,
    parked_ratio=0.9,
    trucks_ratio=0.8,
    works=40,
)
SCAN_CONDITIONS = (
    ScanConditions("scan map", _OUTAGES, WorldChanges(seed=77)),
    ScanConditions("scan map, changed world", _OUTAGES, _CHANGED),
    ScanConditions("scan map, changed world, other lane", _OUTAGES, _CHANGED, lane="other"),
    ScanConditions("scan map, changed world, opposite direction", _OUTAGES, _CHANGED, lane="opposite"),
    ScanConditions("scan map, kidnapped", _SILENT, WorldChanges(seed=79), kidnaps=True),
    ScanConditions("scan map, changed world, kidnapped", _SILENT, _CHANGED, kidnaps=True),
)
TRUCKS = ScanConditions("scan map, trucks", _OUTAGES, _TRUCKS)
# Of long tests for false alarms: GNSS, which silences alarms, is there for a quarter of the way.
DAY = ScanConditions("scan map, changed world, further day", _MOSTLY_SILENT, _CHANGED)


@dataclass(frozen=True, slots=True, eq=False)
class ScanDrive:
    """drive: as for the other rows; scan_cpu_s (k,): of the worker; agreement (k,)

    lost, doubt (n,) at each tick; doubt also while GNSS confirms the pose
    kidnaps: of each, whether the vehicle was slow within 2 s, and right again within 20 s
    """

    drive: Drive
    scan_cpu_s: Array
    agreement: Array
    lost: Array
    doubt: Array
    kidnaps: tuple[bool, ...]


def map_of_way(road_map: RoadMap, way: Trace, seed: int) -> dict[tuple[int, int], Surfels]:
    """Tiles of the way, as `campusloop workshop map --clouds` makes them from a drive on the map's day."""
    day = MAP_DAY + seed
    scene = StaticScene(road_map, SCENE_SEED, WorldChanges(seed=day))
    lidar = LidarDrive(scene, way, day)
    fixes = fixes_of(road_map, way, scene.ground, day)
    cloud_map = map_scans(lidar.clouds(), lidar.scans, fixes, _PARAMS, NoProgress())
    return tiles_of(cloud_map.surfels)


def scan_drive(
    way: Trace, room: ScanMapLocalization, tiles: dict[tuple[int, int], Surfels], road_map: RoadMap,
    conditions: ScanConditions, seed: int,
) -> ScanDrive:  # fmt: skip
    """Everything random is drawn from the seed."""
    rng = np.random.default_rng([seed, 7])
    receiver = CampusReceiver(road_map.origin, GnssNoise(), Sky(road_map.buildings, rng), rng)
    imu = Imu(IMU, rng)
    wheel_scale = 1.0 + float(rng.standard_normal()) * WHEEL_SCALE_STD
    lidar = LidarDrive(StaticScene(road_map, SCENE_SEED, conditions.changes), way, seed)
    worker = ScanLocalizer(
        lambda ix, iy: tiles.get((ix, iy)), TILE_M, _PARAMS.surfaces.voxel_m, lidar.T_base_sensor
    )
    due: deque[tuple[int, ScanPose]] = deque()
    state, rows, cpu_s, agreement, kidnapped = room.initial(), [], [], [], []
    for tick in range(SCAN_TICKS * lidar.scans):
        now_ns, truth = STEP_NS * (tick + 1), view_of(way, tick)
        # Learned under the sky; the receiver is then silent.
        is_silent = conditions.kidnaps and tick > _KIDNAP_FROM_TICK
        receiver.silent = is_silent or is_outage(truth.odometer_m, conditions.receiver)
        wheel_mps = 0.0
        if truth.speed_mps > 0.0:
            noisy_mps = truth.speed_mps * wheel_scale + float(rng.standard_normal()) * WHEEL_NOISE_MPS
            wheel_mps = WHEEL_STEP_MPS * round(noisy_mps / WHEEL_STEP_MPS)
        motion = VehicleMotion(now_ns, wheel_mps, 0.0, 0.0, 0.0, True, False, True, 1.0)
        fix = receiver.fix(now_ns, truth)
        items: list[GnssFix | ImuSample | ScanPose] = [imu.sample(now_ns, truth)]
        items += [fix] if fix is not None else []
        while due and due[0][0] <= tick:
            items.append(due.popleft()[1])
        if is_silent and tick % _KIDNAP_EVERY_TICKS == 0:
            state = _kidnapped(state, rng)
            kidnapped.append(tick)
        begun_s = time.process_time()
        ego, state = room.step(state, motion, tuple(items), now_ns)
        spent_s = time.process_time() - begun_s
        # The last point of a turn of 50 ms is there two ticks after its first.
        if tick % SCAN_TICKS == 3:
            number = tick // SCAN_TICKS
            cloud = lidar.scan(number)
            # The state of tick n has the stamp n + 1.
            found = _matched(worker, room, state, cloud, (SCAN_TICKS * number + 1) * STEP_NS)
            if found is not None:
                pose, scan_s = found
                cpu_s.append(scan_s)
                if pose is not None:
                    agreement.append(pose.agreement)
                    due.append((tick + _DELAY_TICKS, pose))
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
                state.doubt,
            )
        )
    table = np.array(rows, dtype=np.float64)
    drive = Drive(*(table[:, i] for i in range(6)))
    return ScanDrive(
        drive, np.array(cpu_s), np.array(agreement), table[:, 6], table[:, 7],
        tuple(_is_found(drive, tick) for tick in kidnapped if tick + 1_000 < len(table)),
    )  # fmt: skip


def _matched(
    worker: ScanLocalizer, room: ScanMapLocalization, state: ScanMapState, cloud: PointCloud, stamp_ns: int
) -> tuple[ScanPose | None, float] | None:
    """(the scan's pose, CPU seconds); None before there is a prior."""
    stamped = PointCloud(stamp_ns, cloud.points_sensor, cloud.intensities, cloud.rings, cloud.offsets_ns)
    prior = room.prior(state, stamp_ns)
    if prior is None:
        return None
    begun_s = time.process_time()
    pose = worker.step(stamped, prior)
    return pose, time.process_time() - begun_s


def _kidnapped(state: ScanMapState, rng: np.random.Generator) -> ScanMapState:
    angle, size_m = float(rng.uniform(0.0, 2.0 * math.pi)), float(rng.uniform(*_KIDNAP_M))
    mean = state.filter.mean.copy()
    mean[X] += size_m * math.cos(angle)
    mean[Y] += size_m * math.sin(angle)
    mean[YAW] = wrap_angle(mean[YAW] + float(rng.uniform(-_KIDNAP_RAD, _KIDNAP_RAD)))
    return msgspec.structs.replace(state, filter=msgspec.structs.replace(state.filter, mean=mean))


def _is_found(drive: Drive, tick: int) -> bool:
    """Whether the vehicle was slow within 2 s, and right again within 20 s."""
    error_m, drivable = drive.error_m[tick : tick + 1_000], drive.drivable[tick : tick + 1_000]
    right = np.flatnonzero(error_m < 0.3)
    if len(right) == 0:
        return False
    return bool((drivable[: int(right[0])] > 0.0).sum() <= 100)
