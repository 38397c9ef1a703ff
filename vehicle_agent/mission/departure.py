"""Departure check of a requested stop: who or what is too near to set off."""

import math

import numpy as np

from contract.geometry import Array, inverse, transform_points
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, Ego, Tracks, World

_AGE_S_MAX = 1.0
_MOVES_MPS = 0.3


def nearest_hindrance_m(world: World, ego: Ego, rules: MissionRules) -> float:
    """Distance from the outline to the nearest hindrance, inf for none.

    Tracked people, cyclists and whatever moves count within near_m around the outline, except behind the
    rear bumper, which the vehicle leaves. What stands, tracked or not, counts only where the vehicle drives:
    before the bumper within near_m, and alongside within beside_m. A wall beside a stop never goes away.
    """
    return min(_nearest_track_m(world.tracks, ego, rules), _nearest_standing_m(world.points_map, ego, rules))


def _nearest_track_m(tracks: Tracks, ego: Ego, rules: MissionRules) -> float:
    if len(tracks.ids) == 0:
        return math.inf
    age_s = min(max((ego.stamp_ns - tracks.stamp_ns) * 1e-9, 0.0), _AGE_S_MAX)
    centres = tracks.poses_map[:, :2] + age_s * tracks.velocities_map_mps
    # A person's size is a diameter; other road users are turned any way.
    radii = 0.5 * np.hypot(tracks.sizes_m[:, 0], tracks.sizes_m[:, 1])
    is_person = tracks.kinds == PEDESTRIAN
    radii[is_person] = 0.5 * tracks.sizes_m[is_person, 0]
    speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
    x, ahead_m, beside_m = _gaps(centres, ego, rules)
    gaps = np.hypot(ahead_m, beside_m) - radii
    # A position that is not finite may be anywhere.
    gaps[~np.isfinite(gaps)] = 0.0
    counts = is_person | (tracks.kinds == CYCLIST) | ~(speeds <= _MOVES_MPS)
    counts &= ~(x + radii < -rules.body.back_m)
    in_the_way = (x > rules.body.front_m) & (beside_m - radii <= rules.beside_m)
    near = (counts | in_the_way) & (gaps < rules.near_m)
    return float(np.maximum(gaps[near], 0.0).min(initial=math.inf))


def _nearest_standing_m(points_map: Array, ego: Ego, rules: MissionRules) -> float:
    if len(points_map) == 0:
        return math.inf
    x, ahead_m, beside_m = _gaps(points_map, ego, rules)
    near = (x >= -rules.body.back_m) & (beside_m <= rules.beside_m) & (ahead_m < rules.near_m)
    return float(np.hypot(ahead_m[near], beside_m[near]).min(initial=math.inf))


def _gaps(points_map: Array, ego: Ego, rules: MissionRules) -> tuple[Array, Array, Array]:
    """(x in the base frame, distance before or behind the outline, distance beside it) of (n, 2) points."""
    points = transform_points(inverse(ego.pose_map), points_map)
    x, y = points[:, 0], points[:, 1]
    ahead_m = np.maximum(np.maximum(-rules.body.back_m - x, x - rules.body.front_m), 0.0)
    return x, ahead_m, np.maximum(np.abs(y) - rules.half_width_m, 0.0)
