"""A survey drive in the simulated scene: a lidar and a receiver on a vehicle that goes from stop to stop.

It is driven on a day of its own: other vehicles are parked than on the days of passengers, and nothing moves.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from contract.geometry import Array, Pose2, curvatures, resample, wrap_angle
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.projection import project
from contract.roads.routing import find_route, route_line
from simulator.sensors.gnss import CampusReceiver, GnssNoise
from simulator.sensors.lidars.mounts import roof_lidar
from simulator.sensors.lidars.spinning_lidar import MountedLidar, SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.sky import Sky
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Body
from vehicle_agent.lidar.models import VLP16
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.cloud_mapping.gnss_fixes import Fixes

SCAN_EVERY_NS = 100_000_000
# Of two turns at 20 Hz one is used: half the beams of one at 10 Hz, and half the time to cast.
_RATE_HZ = 20.0
_SPACING_M = 0.25
# Lanes of maps bend in corners; vehicles do not.
_SMOOTHED = 17
_SPEED_MPS, _LATERAL_MPS2 = 4.2, 0.8
# Satellites are above alone, so heights are known worse than places; their error wanders.
_HEIGHT_RATIO, _WANDER_S = 2.0, 30.0


class NoWay(Exception):
    """The places are not on one way; the message is one sentence."""


class SurveyDrive:
    """The drive, its scans and its fixes; the seed determines all of it except the scene.

    length_m, scans  of the whole drive; lever_sensor_m: where the fixes' place is in the lidar's frame
    """

    def __init__(self, road_map: RoadMap, stop_ids: Sequence[str], scene_seed: int, seed: int) -> None:
        """From the first resting place through the stops in order and back. Raises NoWay."""
        self._road_map, self._seed = road_map, seed
        self._scene = StaticScene(road_map, scene_seed, WorldChanges(seed=seed))
        points = _way(road_map, stop_ids)
        step = np.diff(points, axis=0)
        course = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
        self._poses = np.column_stack((points, np.append(course, course[-1])))
        bend = np.abs(uniform_filter1d(curvatures(points), _SMOOTHED, mode="nearest"))
        speed = np.minimum(_SPEED_MPS, np.sqrt(_LATERAL_MPS2 / np.maximum(bend, 1e-6)))
        self._times_s = np.append(0.0, np.cumsum(_SPACING_M / speed[1:]))
        self._speed_mps = speed
        self.length_m = _SPACING_M * (len(points) - 1)
        self.scans = int(self._times_s[-1] * 1e9 / SCAN_EVERY_NS)
        mast = roof_lidar(Body(), VLP16)
        self._lidar = MountedLidar(mast.name, mast.T_base_sensor, VLP16, _RATE_HZ)
        x_m, y_m, z_m = (-float(value) for value in mast.T_base_sensor[:3, 3])
        self.lever_sensor_m = (x_m, y_m, z_m)

    def clouds(self) -> Iterator[PointCloud]:
        """All scans in order."""
        lidar = SpinningLidar(self._lidar, self._scene, np.random.default_rng([self._seed, 1]))
        for number in range(self.scans):
            yield lidar.scan(self._trajectory, number * SCAN_EVERY_NS).cloud

    def fixes(self) -> Fixes:
        """Of a receiver between the campus's buildings, ten a second."""
        rng = np.random.default_rng([self._seed, 2])
        origin = self._road_map.origin
        receiver = CampusReceiver(origin, GnssNoise(), Sky(self._road_map.buildings, rng), rng)
        keep = math.exp(-1e-9 * SCAN_EVERY_NS / _WANDER_S)
        wander, rows = float(rng.standard_normal()), []
        for number in range(self.scans):
            stamp_ns = number * SCAN_EVERY_NS
            view = self._view(stamp_ns)
            wander = keep * wander + math.sqrt(1.0 - keep * keep) * float(rng.standard_normal())
            fix = receiver.fix(stamp_ns, view)
            if fix is None or not math.isfinite(fix.position_std_m):
                continue
            pose, std_m = view.pose_map, _HEIGHT_RATIO * fix.position_std_m
            ground_m = float(self._scene.ground.road_m(np.array([pose.x_m]), np.array([pose.y_m]))[0])
            height_m = ground_m + std_m * (0.9 * wander + 0.45 * float(rng.standard_normal()))
            x_m, y_m = project(origin, fix.latitude_deg, fix.longitude_deg)
            rows.append((fix.stamp_ns, x_m, y_m, height_m, fix.position_std_m, std_m))
        stamps_ns = np.array([row[0] for row in rows], dtype=np.int64)
        table = np.array([row[1:] for row in rows])
        return Fixes(origin, stamps_ns, table[:, :3], table[:, [3, 3, 4]], 0)

    def places_map(self) -> Array:
        """(n, 2) the true way, every quarter of a metre."""
        places: Array = self._poses[:, :2]
        return places

    def _at(self, times_s: Array) -> Array:
        """(n, 3) x, y and unwrapped course."""
        return np.column_stack([np.interp(times_s, self._times_s, column) for column in self._poses.T])

    def _trajectory(self, times_ns: Array) -> Array:
        poses: Array = self._scene.ground.poses(self._at(1e-9 * np.asarray(times_ns, dtype=np.float64)))
        return poses

    def _view(self, stamp_ns: int) -> PlantView:
        time_s = 1e-9 * stamp_ns
        before, pose, after = self._at(np.array([time_s - 0.05, time_s, time_s + 0.05]))
        speed_mps = float(np.interp(time_s, self._times_s, self._speed_mps))
        turn_radps = float(after[2] - before[2]) / 0.1
        place = Pose2(float(pose[0]), float(pose[1]), wrap_angle(float(pose[2])))
        return PlantView(place, speed_mps, 0.0, 0.0, 0.0, 0.0, turn_radps, speed_mps * time_s, 1.0)


def _way(road_map: RoadMap, stop_ids: Sequence[str]) -> Array:
    """(n, 2) points of the drive, a quarter of a metre apart."""
    if not road_map.resting_places:
        raise NoWay(f"{road_map.name} has no resting place to begin at.")
    network, rest = RoadNetwork(road_map), road_map.resting_places[0]
    stops = {stop.stop_id: (stop.lane_id, stop.s_m) for stop in road_map.stops}
    unknown = [stop_id for stop_id in stop_ids if stop_id not in stops]
    if unknown:
        raise NoWay(f"The map has no stop {', '.join(unknown)}; it has {', '.join(stops)}.")
    here = (rest.lane_id, rest.s_m)
    pieces = []
    for there in (*(stops[stop_id] for stop_id in stop_ids), here):
        route = find_route(network, *here, *there)
        if route is None:
            raise NoWay(f"There is no way from lane {here[0]} to lane {there[0]}.")
        pieces.append(route_line(network, route).points)
        here = there
    points = np.concatenate(pieces)
    apart = np.hypot(*np.diff(points, axis=0).T) > 1e-6
    fine = resample(points[np.concatenate(([True], apart))], _SPACING_M)
    for _ in range(2):
        fine = uniform_filter1d(fine, _SMOOTHED, axis=0, mode="nearest")
    return resample(fine, _SPACING_M)
