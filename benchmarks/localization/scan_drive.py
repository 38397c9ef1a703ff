"""Scan-to-map localization along a way: the map of another day's drive, this day's scans and their worker."""

import dataclasses
import time
from collections import deque
from dataclasses import dataclass

import numpy as np

from benchmarks.localization.drive import STEP_NS, Conditions, Drive
from benchmarks.localization.sensed_drive import (
    LEARNED_TICKS,
    MAP_DAY,
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
from benchmarks.mapping.campus_drive import MOUNT_M, SCAN_TICKS, LidarDrive, Mount, Trace
from benchmarks.mapping.receiver import fixes_of
from contract.geometry import Array
from contract.point_map.tiles import Surfels
from contract.roads.model import RoadMap
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization, ScanMapState
from vehicle_agent.localization.scan_map.localizer import ScanLocalizer
from vehicle_agent.signals import Navigation, ScanPose
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.cloud_mapping.map_folder import TILE_M, tiles_of
from workshop.cloud_mapping.mapping import CloudMappingParams, NoProgress, map_scans

# From the end of a scan to its pose: the worker's time, and the mailboxes.
_DELAY_TICKS = 5
_PARAMS = CloudMappingParams(lever_sensor_m=(-MOUNT_M[0], -MOUNT_M[1], -MOUNT_M[2]))
# Within the reach of the worker's search.
_KIDNAPPING = Kidnapping(1_100, (1.0, 8.0))


@dataclass(frozen=True, slots=True, eq=False)
class ScanConditions:
    """One row: receiver, as for the other rows; changes of the world since the map's day; the way driven.

    lane   "same" as on the map's day, "other" to the left of it, or "opposite": the other one, and back
    kidnapping  now and then, without GNSS
    """

    name: str
    receiver: Conditions
    changes: WorldChanges
    lane: str = "same"
    kidnapping: Kidnapping | None = None

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
    ScanConditions("scan map, kidnapped", _SILENT, WorldChanges(seed=79), kidnapping=_KIDNAPPING),
    ScanConditions("scan map, changed world, kidnapped", _SILENT, _CHANGED, kidnapping=_KIDNAPPING),
)
TRUCKS = ScanConditions("scan map, trucks", _OUTAGES, _TRUCKS)
# Of long tests for false alarms: GNSS, which silences alarms, is there for a quarter of the way.
DAY = ScanConditions("scan map, changed world, further day", _MOSTLY_SILENT, _CHANGED)


@dataclass(frozen=True, slots=True, eq=False)
class ScanDrive:
    """drive: as for the other rows; scan_cpu_s (k,): of the worker; agreement (k,)

    lost, doubt (n,) at each tick; doubt also while GNSS confirms the pose
    kidnaps: what became of each
    """

    drive: Drive
    scan_cpu_s: Array
    agreement: Array
    lost: Array
    doubt: Array
    kidnaps: tuple[Kidnapped, ...]


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
    conditions: ScanConditions, seed: int, mount_m: Mount = MOUNT_M,
) -> ScanDrive:  # fmt: skip
    """mount_m: of the vehicle's lidar. Everything random is drawn from the seed."""
    rng = np.random.default_rng([seed, 17])
    sensed = SensedDrive(way, road_map, conditions.receiver, seed)
    lidar = LidarDrive(StaticScene(road_map, SCENE_SEED, conditions.changes), way, seed, mount_m)
    worker = ScanLocalizer(
        lambda ix, iy: tiles.get((ix, iy)), TILE_M, _PARAMS.surfaces.voxel_m, lidar.T_base_sensor
    )
    due: deque[tuple[int, ScanPose]] = deque()
    state, table, cpu_s, agreement, ticks = room.initial(), DriveRows(way), [], [], []
    kidnapping = conditions.kidnapping
    for tick in range(SCAN_TICKS * lidar.scans):
        # Learned under the sky; the receiver is then silent.
        is_silent = kidnapping is not None and tick > LEARNED_TICKS
        motion, measured = sensed.tick(tick, is_silent=is_silent)
        items: list[Navigation] = [*measured]
        while due and due[0][0] <= tick:
            items.append(due.popleft()[1])
        is_time = kidnapping is not None and is_silent and tick % kidnapping.every_ticks == 0
        if kidnapping is not None and is_time and table.is_right():
            state = placed_at(state, kidnapping.drawn(pose_of(state), rng))
            ticks.append(tick)
        begun_s = time.process_time()
        ego, state = room.step(state, motion, tuple(items), stamp_ns(tick))
        table.add(tick, room, state, ego, time.process_time() - begun_s)
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
    drive, lost, doubt = table.drive()
    return ScanDrive(drive, np.array(cpu_s), np.array(agreement), lost, doubt, kidnapped(drive, ticks))


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
