"""A survey drive with a planar scanner in the simulated scene: what the workshop makes an occupancy map of.

The vehicle drives on a day of its own: other vehicles are parked than on the days of passengers. Its log has
what a real one has: scans, the odometry of wheels and gyroscope, and a receiver's fixes.
"""

import math
from collections.abc import Callable

import msgspec
import numpy as np
from scipy.ndimage import uniform_filter1d

from contract.geometry import Array, Pose2, curvatures, resample, wrap_angle
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.projection import project
from contract.roads.routing import find_route, route_line
from simulator.sensors.gnss import CampusReceiver, GnssNoise
from simulator.sensors.imu import Imu, ImuNoise
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.scene_planar import VehiclePlanarScanner
from simulator.sensors.sky import Sky
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Profile
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.localization.planar_map.matcher import laser_scan
from vehicle_agent.signals import GnssFix, VehicleMotion
from vehicle_agent.signals.laser_scan import LaserScan
from workshop.carmen.beams import Beams
from workshop.carmen.laser_logs import LaserLog
from workshop.cloud_mapping.gnss_fixes import Fixes

STEP_NS = 20_000_000
_SPACING_M = 0.25
# Lanes of maps bend in corners; vehicles do not.
_SMOOTHED = 17
_SPEED_MPS, _LATERAL_MPS2 = 3.5, 0.8
_SCANS_HZ = 5.0
_FIX_TICKS = 5
# Of tyres as they are worn and loaded, and of the wheels' report.
_WHEEL_SCALE_STD, _WHEEL_NOISE_MPS = 0.01, 0.02
# A route that shows less of the campus is not worth its way.
_FRESH_M_MIN = 60.0
_SQUARE_M = 8.0


class NoTour(Exception):
    """The map has no way from stop to stop; the message is one sentence."""


def campus_tour(road_map: RoadMap) -> Array:
    """(n, 2) points of a drive over all roads that lead from one stop to another. Raises NoTour.

    It always goes to the stop on whose way most is new. The other side of a road that was driven is not new:
    the scanner saw its surroundings.
    """
    network, stops = RoadNetwork(road_map), road_map.stops
    lines = {}
    for here in stops:
        for there in stops:
            route = find_route(network, here.lane_id, here.s_m, there.lane_id, there.s_m)
            if here is not there and route is not None:
                lines[here.stop_id, there.stop_id] = route_line(network, route).points
    if not lines:
        raise NoTour(f"{road_map.name} has no way from one stop to another.")
    seen: set[tuple[int, int]] = set()
    at = next(iter(lines))[0]
    pieces: list[Array] = []
    while True:
        fresh = {pair[1]: len(_squares(line) - seen) for pair, line in lines.items() if pair[0] == at}
        best = max(fresh, key=lambda stop_id: fresh[stop_id], default=None)
        # On a small campus the first way is shorter, and is driven all the same.
        if best is None or (pieces and fresh[best] * _SQUARE_M < _FRESH_M_MIN):
            break
        pieces.append(lines[at, best])
        seen |= _squares(lines[at, best])
        at = best
    return np.concatenate(pieces)


def _squares(points: Array) -> set[tuple[int, int]]:
    return {(int(x), int(y)) for x, y in np.floor(points / _SQUARE_M)}


class LaserSurvey:
    """One drive along points (n, 2): `record` it. The seed determines all of it except the scene.

    length_m, duration_s  of the drive
    """

    def __init__(
        self, road_map: RoadMap, profile: Profile, points: Array, scene_seed: int, seed: int
    ) -> None:
        """profile: with a planar scanner. Raises SceneError."""
        self._road_map, self._profile = road_map, _with_rate(profile)
        self._scene = StaticScene(road_map, scene_seed, WorldChanges(seed=seed))
        self._rng = np.random.default_rng([seed, *b"laser survey"])
        line = _smoothed(points)
        step = np.diff(line, axis=0)
        course = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
        bend = np.abs(uniform_filter1d(curvatures(line), _SMOOTHED, mode="nearest"))
        speed = np.minimum(_SPEED_MPS, np.sqrt(_LATERAL_MPS2 / np.maximum(bend, 1e-6)))
        # It sets off and comes to rest; the receiver's and the gyroscope's errors are learned on the way.
        self._rows = np.column_stack((line, np.append(course, course[-1]), speed))
        self._times_s = np.append(0.0, np.cumsum(_SPACING_M / speed[1:]))
        self.length_m = _SPACING_M * (len(line) - 1)
        self.duration_s = float(self._times_s[-1])

    def record(self, advance: Callable[[int], None]) -> tuple[LaserLog, Fixes]:
        """The log and the fixes of the vehicle's base; `advance` is told of each second."""
        rng, road_map, profile = self._rng, self._road_map, self._profile
        sky = Sky(road_map.buildings, rng)
        receiver, imu = CampusReceiver(road_map.origin, GnssNoise(), sky, rng), Imu(ImuNoise(), rng)
        scanner = VehiclePlanarScanner(self._scene, profile, rng)
        params = profile.planar_scanner
        laser = Pose2(params.x_m, params.y_m, params.yaw_rad)
        wheel_ratio = 1.0 + _WHEEL_SCALE_STD * float(rng.standard_normal())
        # Its odometry is what the log has; its poses are not used.
        room = GnssInsLocalization(road_map.origin)
        state, scans, odometry, fixes = room.initial(), [], [], []
        for tick in range(1, int(self.duration_s * 1e9 / STEP_NS)):
            now_ns = tick * STEP_NS
            truth = self._view(now_ns)
            noise_mps = _WHEEL_NOISE_MPS * float(rng.standard_normal())
            speed_mps = truth.speed_mps * wheel_ratio + noise_mps
            motion = VehicleMotion(now_ns, speed_mps, 0.0, 0.0, 0.0, True, False, True, 1.0)
            fix = receiver.fix(now_ns, truth)
            items = [imu.sample(now_ns, truth), *(() if fix is None else (fix,))]
            _, state = room.step(state, motion, tuple(items), now_ns)
            if fix is not None and tick % _FIX_TICKS == 0 and math.isfinite(fix.position_std_m):
                fixes.append(fix)
            found = scanner.step(now_ns, truth)
            if found is not None:
                scans.append(laser_scan(now_ns, found[0].astype(np.float64), laser, params.step_rad))
                odometry.append((state.odometry.x_m, state.odometry.y_m, state.odometry.yaw_rad))
            if now_ns % 1_000_000_000 == 0:
                advance(1)
        return self._log(scans, odometry, laser), self._fixes(fixes)

    def places_map(self) -> Array:
        """(n, 2) the true way, every quarter of a metre."""
        places: Array = self._rows[:, :2]
        return places

    def _view(self, now_ns: int) -> PlantView:
        time_s = 1e-9 * now_ns
        moments = np.array([time_s - 0.02, time_s, time_s + 0.02])
        before, here, after = np.column_stack([np.interp(moments, self._times_s, c) for c in self._rows.T])
        pose = Pose2(float(here[0]), float(here[1]), wrap_angle(float(here[2])))
        turn_radps = float(after[2] - before[2]) / 0.04
        return PlantView(pose, float(here[3]), 0.0, 0.0, 0.0, 0.0, turn_radps, float(here[3]) * time_s, 1.0)

    def _log(
        self, scans: list[LaserScan], odometry: list[tuple[float, float, float]], laser: Pose2
    ) -> LaserLog:
        step_rad = self._profile.planar_scanner.step_rad
        count = len(scans[0].ranges_m)
        ranges_m = np.array([scan.ranges_m for scan in scans])
        ranges_m[~np.isfinite(ranges_m)] = np.nan
        stamps_s = 1e-9 * np.array([scan.stamp_ns for scan in scans], dtype=np.float64)
        beams = Beams(-step_rad * (count // 2), step_rad, count)
        return LaserLog(beams, ranges_m, stamps_s, np.array(odometry), laser, ())

    def _fixes(self, fixes: list[GnssFix]) -> Fixes:
        origin = self._road_map.origin
        places = np.array([(*project(origin, fix.latitude_deg, fix.longitude_deg), 0.0) for fix in fixes])
        std_m = np.array([(fix.position_std_m, fix.position_std_m, math.inf) for fix in fixes])
        return Fixes(origin, np.array([fix.stamp_ns for fix in fixes], dtype=np.int64), places, std_m, 0)


def _with_rate(profile: Profile) -> Profile:
    scanner = msgspec.structs.replace(profile.planar_scanner, rate_hz=_SCANS_HZ)
    return msgspec.structs.replace(profile, planar_scanner=scanner)


def _smoothed(points: Array) -> Array:
    apart = np.hypot(*np.diff(points, axis=0).T) > 1e-6
    fine = resample(points[np.concatenate(([True], apart))], _SPACING_M)
    for _ in range(2):
        fine = uniform_filter1d(fine, _SMOOTHED, axis=0, mode="nearest")
    return resample(fine, _SPACING_M)
