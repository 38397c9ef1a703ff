"""A reference line as waypoints a metre apart, each with a speed that its curve allows (GEM, section IV)."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, arc_lengths, curvatures, pose_at
from contract.roads.routing import ReferenceLine

SPACING_M = 1.0


class WaypointRules(msgspec.Struct, frozen=True):
    """Speeds along a line: cap (m/s), lateral acceleration in curves and deceleration before them (m/s2).

    overrun_m  how far straight on the list goes beyond the line's end, so that there is always a waypoint to
               aim at
    """

    speed_mps_max: float = 3.0
    lateral_accel_mps2: float = 0.5
    decel_mps2: float = 0.5
    overrun_m: float = 8.0


class Waypoints(msgspec.Struct, frozen=True):
    """points_map (n, 2), s_m (n,) along the list and speeds_mps (n,); what a waypoint file holds."""

    points_map: np.ndarray
    s_m: np.ndarray
    speeds_mps: np.ndarray

    def ahead(self, s_m: float, length_m: float) -> slice:
        """Which waypoints lie beyond s_m, at most length_m farther."""
        first = int(np.searchsorted(self.s_m, s_m, side="right"))
        return slice(first, int(np.searchsorted(self.s_m, s_m + length_m, side="right")))


def waypoints_from_line(line: ReferenceLine, rules: WaypointRules) -> Waypoints:
    """Waypoints along the line and `overrun_m` beyond it; their s is the line's."""
    points, s = every_metre(line.points, line.s, SPACING_M, rules.overrun_m)
    limit = np.interp(s, line.s, line.speed_limit_mps)
    speeds = allowed_speeds(points, np.minimum(limit, rules.speed_mps_max), rules)
    return Waypoints(points, s, speeds)


def waypoints_from_points(points_map: Array, speeds_mps: Array, rules: WaypointRules) -> Waypoints:
    """Recorded waypoints (n, 2) with their speeds (n,), lowered before slower ones.

    Curves are left to the recorded speeds: a metre between noisy positions makes a poor curvature.
    """
    points: Array = np.ascontiguousarray(points_map, dtype=np.float64)
    s = arc_lengths(points)
    capped = np.minimum(np.asarray(speeds_mps, dtype=np.float64), rules.speed_mps_max)
    straight = np.zeros(len(points))
    speeds = limited_speeds(s, straight, capped, rules.lateral_accel_mps2, rules.decel_mps2)
    return Waypoints(points, s, speeds)


def curve_speed_mps(radius_m: float, lateral_accel_mps2: float = 0.5) -> float:
    """v_max = sqrt(0.5 r): the speed at which a curve of this radius stays comfortable (GEM, section IV)."""
    return math.sqrt(lateral_accel_mps2 * radius_m)


def allowed_speeds(points: Array, capped_mps: Array, rules: WaypointRules) -> Array:
    """(n,) the caps (n,), lowered in curves, and before them so that the deceleration is held."""
    return limited_speeds(
        arc_lengths(points), curvatures(points), capped_mps, rules.lateral_accel_mps2, rules.decel_mps2
    )


@njit(cache=True)
def every_metre(points: Array, s: Array, spacing_m: float, overrun_m: float) -> tuple[Array, Array]:
    """((n, 2), (n,)) places at s = 0, spacing, 2 spacing, ... and straight on beyond the end."""
    total = s[-1]
    count = math.floor((total + overrun_m) / spacing_m) + 1
    places = np.empty((count, 2))
    along = np.empty(count)
    end_x, end_y, end_yaw = pose_at(points, s, total)
    for k in range(count):
        q = k * spacing_m
        along[k] = q
        if q <= total:
            x, y, _ = pose_at(points, s, q)
            places[k, 0], places[k, 1] = x, y
        else:
            places[k, 0] = end_x + (q - total) * math.cos(end_yaw)
            places[k, 1] = end_y + (q - total) * math.sin(end_yaw)
    return places, along


@njit(cache=True)
def limited_speeds(s: Array, kappa: Array, cap: Array, lateral: float, decel: float) -> Array:
    """(n,) min(cap, sqrt(lateral / |kappa|)), then a backward pass: v_i^2 <= v_(i+1)^2 + 2 decel ds."""
    n = s.shape[0]
    v = np.empty(n)
    for i in range(n):
        v[i] = min(cap[i], math.sqrt(lateral / max(abs(kappa[i]), 1e-6)))
    for i in range(n - 2, -1, -1):
        v[i] = min(v[i], math.sqrt(v[i + 1] * v[i + 1] + 2.0 * decel * (s[i + 1] - s[i])))
    return v
