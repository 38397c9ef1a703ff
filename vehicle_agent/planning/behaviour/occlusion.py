"""How fast to pass places from which somebody may come that cannot be seen yet.

A person who steps out from behind something reaches the swept path after t = h / v_run, h being the hidden
place's distance from it. A vehicle that would meet them there can stop in front of them unless
v t_react + v^2 / 2b > D > v t for the distance D to go, and there is no such D while v <= 2 b (t - t_react).
With 1.4 m/s and 5 m/s2 this is the GEM paper's side clearance: 1.15 m at 3 m/s.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array


@njit(cache=True)
def hidden_beside(
    points: Array,
    yaws: Array,
    offsets: Array,
    first: int,
    last: int,
    half_m: float,
    view: Array,
    ranges: Array,
    solid: Array,
    reach_m: float,
    step_m: float,
) -> Array:
    """(n,) distance from the body's side to the nearest hidden place that leads to the path, inf for none.

    points (n, 2), yaws, offsets (n,): stations and the path's offset; view (3,) the sensor's pose, ranges
    (b,) its sight; solid (m, 2): obstacle cells, through which nobody comes.
    """
    n, bearings = points.shape[0], ranges.shape[0]
    found = np.full(n, np.inf)
    if bearings == 0:
        return found
    near = 0.4
    for i in range(first, min(last, n)):
        nx, ny = -math.sin(yaws[i]), math.cos(yaws[i])
        x0, y0 = points[i, 0] + offsets[i] * nx, points[i, 1] + offsets[i] * ny
        for side in (1.0, -1.0):
            h = 0.0
            while h <= reach_m:
                x = x0 + side * (half_m + h) * nx
                y = y0 + side * (half_m + h) * ny
                if _is_solid(solid, x, y, near):
                    break
                dx, dy = x - view[0], y - view[1]
                distance = math.hypot(dx, dy)
                bearing = math.atan2(dy, dx) - view[2]
                k = math.floor((bearing + math.pi) / (2.0 * math.pi) * bearings) % bearings
                if distance > ranges[k] + 0.5:
                    found[i] = min(found[i], h)
                    break
                h += step_m
    return found


@njit(cache=True)
def _is_solid(solid: Array, x: float, y: float, near: float) -> bool:
    stands = False
    for k in range(solid.shape[0]):
        stands = stands or (abs(solid[k, 0] - x) < near and abs(solid[k, 1] - y) < near)
    return stands


@njit(cache=True)
def occlusion_speeds(
    hidden_m: Array,
    step_m: float,
    front_m: float,
    run_mps: float,
    react_s: float,
    decel_mps2: float,
    least_mps: float,
    cap_mps: float,
) -> Array:
    """(n,) speed limit of the rear axle from `hidden_beside`; each holds over the braking distance."""
    n = hidden_m.shape[0]
    limits = np.full(n, cap_mps)
    for i in range(n):
        if not np.isfinite(hidden_m[i]):
            continue
        v = max(least_mps, 2.0 * decel_mps2 * (hidden_m[i] / run_mps - react_s))
        if v >= cap_mps:
            continue
        braking_m = cap_mps * react_s + cap_mps * cap_mps / (2.0 * decel_mps2)
        from_i = i - math.ceil((front_m + braking_m) / step_m)
        to_i = i - math.floor(front_m / step_m)
        for k in range(max(0, from_i), max(0, min(n, to_i + 1))):
            limits[k] = min(limits[k], v)
    return limits
