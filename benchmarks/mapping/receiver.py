"""What the receiver of a mapping drive says, 10 times a second."""

import numpy as np

from benchmarks.mapping.campus_drive import SCAN_TICKS, TICK_S, Trace
from contract.geometry import Pose2, wrap_angle
from contract.roads.model import RoadMap
from contract.roads.projection import project
from simulator.sensors.gnss import CampusReceiver, GnssNoise
from simulator.sensors.scene.ground import Ground
from simulator.sensors.sky import Sky
from simulator.vehicle.plant import PlantView
from workshop.cloud_mapping.gnss_fixes import Fixes


def view_of(drive: Trace, tick: int) -> PlantView:
    """The vehicle's true motion at a tick, as sensors take it."""
    pose = Pose2(float(drive.x_m[tick]), float(drive.y_m[tick]), wrap_angle(float(drive.yaw_rad[tick])))
    speed_mps, yaw_rate_radps = float(drive.speed_mps[tick]), float(drive.yaw_rate_radps[tick])
    return PlantView(pose, speed_mps, 0.0, 0.0, 0.0, 0.0, yaw_rate_radps, float(drive.odometer_m[tick]), 1.0)


# Satellites are above alone, so heights are known worse than places.
_HEIGHT_RATIO = 2.0
_WANDER_S = 30.0


def fixes_of(road_map: RoadMap, drive: Trace, ground: Ground, seed: int) -> Fixes:
    """The fixes with a solution, of a receiver between the campus's buildings."""
    rng = np.random.default_rng([seed, 7])
    heights_m = ground.road_m(drive.x_m[::SCAN_TICKS], drive.y_m[::SCAN_TICKS])
    keep, wander = float(np.exp(-TICK_S * SCAN_TICKS / _WANDER_S)), float(rng.standard_normal())
    receiver = CampusReceiver(road_map.origin, GnssNoise(), Sky(road_map.buildings, rng), rng)
    rows = []
    for tick in range(0, len(drive), SCAN_TICKS):
        wander = keep * wander + np.sqrt(1.0 - keep * keep) * float(rng.standard_normal())
        fix = receiver.fix(round(1e9 * TICK_S) * tick, view_of(drive, tick))
        if fix is not None and np.isfinite(fix.position_std_m):
            xy = project(road_map.origin, fix.latitude_deg, fix.longitude_deg)
            height_std_m = _HEIGHT_RATIO * fix.position_std_m
            error_m = height_std_m * (0.9 * wander + 0.45 * float(rng.standard_normal()))
            height_m = float(heights_m[tick // SCAN_TICKS]) + error_m
            rows.append((fix.stamp_ns, *xy, height_m, fix.position_std_m, height_std_m))
    stamps_ns = np.array([row[0] for row in rows], dtype=np.int64)
    table = np.array([row[1:] for row in rows])
    return Fixes(road_map.origin, stamps_ns, table[:, :3], table[:, [3, 3, 4]], 0)
