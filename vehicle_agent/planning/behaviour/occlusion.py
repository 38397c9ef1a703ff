"""Speed limits past hidden places, from which a person may come who cannot be seen yet.

A person may already be running towards the swept path behind the corner of something that hides the view.
From a distance D to go they come into sight h(D) beside it: the nearer the vehicle, the larger h. They reach
the path after t(D) = h(D) / v_run. The vehicle meets no one if it can stop within D, or has passed by then:
v t_react + v^2 / 2b <= D, or v t(D) >= D. Where neither holds at the highest v, the limit makes the first
hold. With h held fixed this is the GEM paper's side clearance: 1.15 m at 3 m/s.

Where an infrastructure camera has seen that the ground is free, a runner comes from beyond it. The camera may
be wrong, so somebody who walks may still come from any hidden place.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from contract.geometry import Array

# Columns of a hidden place: distance from the body's side, and its hiding corner: how far before the place
# along the line, and how far beside the path.
# H_CLEARED: to this far beside the body a camera has seen that nobody is there.
H_BESIDE, H_CORNER_BEFORE, H_CORNER_BESIDE, H_CLEARED = range(4)
_SOLID_M = 0.4


class PathStations(NamedTuple):
    """Stations of the line, points (n, 2) and yaws (n,), with the path's offsets (n,); first and last to
    look at."""

    points: Array
    yaws: Array
    offsets: Array
    first: int
    last: int


class Sight(NamedTuple):
    """What a sensor sees from its pose: ranges_m (b,) by bearing."""

    x_m: float
    y_m: float
    yaw_rad: float
    ranges_m: Array


class OcclusionRules(NamedTuple):
    """The vehicle and the person who may come.

    front_m, sensor_behind_m  bumper ahead of the rear axle; from the bumper back to the sensor
    run_mps                   how fast a person comes from a hidden place
    walk_mps                  the same from ground that a camera has seen to be free
    react_s, decel_mps2       how the vehicle can stop
    creep_mps                 no hidden place makes the vehicle go slower than this
    """

    front_m: float
    sensor_behind_m: float
    half_width_m: float
    run_mps: float
    react_s: float
    decel_mps2: float
    creep_mps: float
    walk_mps: float = 1.9


@njit(cache=True)
def hidden_beside(
    path: PathStations, sight: Sight, solid: Array, half_m: float, reach_m: float, step_m: float
) -> Array:
    """(n, 4) the nearest hidden place beside each station that leads to the path; inf for none, none cleared.

    solid (m, 2): obstacle cells, through which no one comes. Places are tried every step_m from the body's
    side, half_m from its middle, to reach_m.
    """
    n = path.points.shape[0]
    found = np.full((n, 4), np.inf)
    found[:, H_CLEARED] = 0.0
    if sight.ranges_m.shape[0] == 0:
        return found
    for i in range(path.first, min(path.last, n)):
        cos, sin = math.cos(path.yaws[i]), math.sin(path.yaws[i])
        x0, y0 = path.points[i, 0] - path.offsets[i] * sin, path.points[i, 1] + path.offsets[i] * cos
        for side in (1.0, -1.0):
            h = 0.0
            while h <= reach_m:
                x = x0 - side * (half_m + h) * sin
                y = y0 + side * (half_m + h) * cos
                if _is_solid(solid, x, y, _SOLID_M):
                    break
                share = _seen_share(sight, x, y)
                if share < 1.0:
                    if h < found[i, H_BESIDE]:
                        cx = sight.x_m + share * (x - sight.x_m) - x0
                        cy = sight.y_m + share * (y - sight.y_m) - y0
                        found[i, H_BESIDE] = h
                        found[i, H_CORNER_BEFORE] = max(-(cos * cx + sin * cy), 0.05)
                        found[i, H_CORNER_BESIDE] = max(side * (-sin * cx + cos * cy), half_m)
                    break
                h += step_m
    return found


@njit(cache=True)
def _seen_share(sight: Sight, x: float, y: float) -> float:
    """The share of the way to (x, y) that the sensor sees; 1 when it sees the place itself."""
    bearings = sight.ranges_m.shape[0]
    dx, dy = x - sight.x_m, y - sight.y_m
    distance = math.hypot(dx, dy)
    bearing = math.atan2(dy, dx) - sight.yaw_rad
    k = math.floor((bearing + math.pi) / (2.0 * math.pi) * bearings) % bearings
    share: float = sight.ranges_m[k] / distance if distance > sight.ranges_m[k] + 0.5 else 1.0
    return share


@njit(cache=True)
def _is_solid(solid: Array, x: float, y: float, near: float) -> bool:
    stands = False
    for k in range(solid.shape[0]):
        stands = stands or (abs(solid[k, 0] - x) < near and abs(solid[k, 1] - y) < near)
    return stands


@njit(cache=True)
def occlusion_speeds(hidden: Array, step_m: float, cap_mps: float, rules: OcclusionRules) -> Array:
    """(n,) speed limit of the rear axle by station, every step_m, from `hidden_beside`; at most cap_mps."""
    n = hidden.shape[0]
    react_s, decel_mps2 = rules.react_s, rules.decel_mps2
    limits = np.full(n, cap_mps)
    braking_m = cap_mps * react_s + cap_mps * cap_mps / (2.0 * decel_mps2)
    for i in range(n):
        if not np.isfinite(hidden[i, H_BESIDE]):
            continue
        before, beside = hidden[i, H_CORNER_BEFORE], hidden[i, H_CORNER_BESIDE]
        cleared_m = hidden[i, H_CLEARED]
        to_i = i - math.floor(rules.front_m / step_m)
        for k in range(max(0, to_i - math.ceil(braking_m / step_m)), max(0, min(n, to_i + 1))):
            togo_m = (to_i - k) * step_m
            eye_m = togo_m + rules.sensor_behind_m
            # The sight past the corner, at the place's own station; level with the corner all is seen.
            if eye_m <= before + 0.1:
                continue
            seen_m = beside * eye_m / (eye_m - before) - rules.half_width_m
            arrives_s = max(seen_m, cleared_m, 0.0) / rules.run_mps
            if cleared_m > 0.0:
                arrives_s = min(arrives_s, max(seen_m, 0.0) / rules.walk_mps)
            stops_mps = decel_mps2 * (math.sqrt(react_s * react_s + 2.0 * togo_m / decel_mps2) - react_s)
            if stops_mps * arrives_s < togo_m:
                limits[k] = min(limits[k], max(stops_mps, rules.creep_mps))
    return limits
