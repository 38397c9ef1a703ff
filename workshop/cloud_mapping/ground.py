"""The ground below the vehicle, in each keyframe: a plane through the points near the sensor."""

import math
from collections.abc import Sequence

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.odometry.voxel_map import Array32
from workshop.cloud_mapping.pose_graph import Ground


class GroundParams(msgspec.Struct, frozen=True):
    """reach_m: farthest points; slope_rad_max: a sensor or road that leans more is not believed.

    bands_m     of points about the plane, one after the other
    points_min  of the last plane
    """

    reach_m: float = 14.0
    slope_rad_max: float = 0.25
    bands_m: tuple[float, ...] = (0.5, 0.25, 0.12, 0.12)
    points_min: int = 40


def ground_of(clouds: Sequence[Array32], params: GroundParams) -> Ground:
    """Of k clouds (m, 3), sensor frame, whose z axis points about upwards."""
    count = len(clouds)
    normals, heights = np.tile([0.0, 0.0, 1.0], (count, 1)), np.zeros(count)
    known = np.zeros(count, dtype=bool)
    for number, cloud in enumerate(clouds):
        found = _plane(cloud.astype(np.float64), params)
        if found is not None:
            normals[number], heights[number], known[number] = found[0], found[1], True
    return Ground(normals, heights, known)


def _plane(points: Array, params: GroundParams) -> tuple[Array, float] | None:
    """(normal (3,), height of the sensor above the plane)."""
    near = points[np.hypot(points[:, 0], points[:, 1]) < params.reach_m]
    if len(near) < params.points_min:
        return None
    # The ground is the lowest that many points have in common.
    level = float(np.percentile(near[:, 2], 20.0))
    normal, offset = np.array([0.0, 0.0, 1.0]), level
    for band_m in params.bands_m:
        on = near[np.abs(near @ normal - offset) < band_m]
        if len(on) < params.points_min:
            return None
        middle = on.mean(axis=0)
        _, _, axes = np.linalg.svd(on - middle, full_matrices=False)
        normal = axes[2] * math.copysign(1.0, float(axes[2, 2]))
        offset = float(normal @ middle)
        if math.acos(min(1.0, float(normal[2]))) > params.slope_rad_max:
            return None
    return normal, -offset
