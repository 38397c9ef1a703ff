"""What the lidars' driver on a vehicle sends on: one cloud in the base frame at the turn's end.

Planar scanners are handed over in the same way.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array
from simulator.sensors.lidars.firings import Array32, Times
from simulator.sensors.lidars.planar_scanner import PlanarScan


@njit(cache=True)
def moved_to_end(
    points_base: Array32, offsets_ns: Times, end_ns: int, speed_mps: float, yaw_rate_radps: float
) -> Array32:
    """(n, 3) the points as the base sees them at the end of a turn driven at constant speed and yaw rate.

    points_base  (n, 3) each in the base frame of its own moment
    offsets_ns   (n,) their times; end_ns: of the turn's end, both after its begin
    speed_mps, yaw_rate_radps  as the vehicle's own sensors measure them; pitch and roll are left out
    """
    moved = np.empty_like(points_base)
    for k in range(points_base.shape[0]):
        left_s = (end_ns - offsets_ns[k]) * 1e-9
        turned = yaw_rate_radps * left_s
        cos, sin = math.cos(turned), math.sin(turned)
        # The chord of the arc that the base still drives.
        ahead = speed_mps * left_s * math.cos(0.5 * turned)
        aside = speed_mps * left_s * math.sin(0.5 * turned)
        x, y = points_base[k, 0] - ahead, points_base[k, 1] - aside
        moved[k, 0] = cos * x + sin * y
        moved[k, 1] = -sin * x + cos * y
        moved[k, 2] = points_base[k, 2]
    return moved


def planar_points(
    scan: PlanarScan, T_base_sensor: Array, end_ns: int, speed_mps: float, yaw_rate_radps: float
) -> tuple[Array32, Array32]:
    """(points (n, 3) as the base sees them at the turn's end, intensities (n,)) of a planar scan's returns.

    end_ns, speed_mps, yaw_rate_radps  as in `moved_to_end`
    """
    seen = np.isfinite(scan.ranges_m)
    ranges_m, angles_rad = scan.ranges_m[seen], scan.angles_rad[seen]
    level = np.column_stack(
        (ranges_m * np.cos(angles_rad), ranges_m * np.sin(angles_rad), np.zeros(len(ranges_m)))
    )
    based = (level @ T_base_sensor[:3, :3].T + T_base_sensor[:3, 3]).astype(np.float32)
    return moved_to_end(based, scan.offsets_ns[seen], end_ns, speed_mps, yaw_rate_radps), scan.intensities[
        seen
    ]
