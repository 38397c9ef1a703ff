"""How fast to pass places from which somebody may come that cannot be seen yet.

Behind the corner of something that hides the view, somebody may already be running towards the swept path.
From a distance D to go they come into sight h(D) beside it, the more the nearer the vehicle is, and reach it
after t(D) = h(D) / v_run. The vehicle meets nobody if it can stop within D, or has passed by then:
v t_react + v^2 / 2b <= D, or v t(D) >= D. Where neither holds at the highest v, the first is made to.
With h held fixed this is the GEM paper's side clearance: 1.15 m at 3 m/s.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array

# columns of a hidden place: distance from the body's side, and its hiding corner: how far before the place
# along the line, and how far beside the path
H_BESIDE, H_CORNER_BEFORE, H_CORNER_BESIDE = range(3)


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
    """(n, 3) the nearest hidden place beside each station that leads to the path; inf for none.

    points (n, 2), yaws, offsets (n,): stations and the path's offset; view (3,) the sensor's pose, ranges
    (b,) its sight; solid (m, 2): obstacle cells, through which nobody comes.
    """
    n, bearings = points.shape[0], ranges.shape[0]
    found = np.full((n, 3), np.inf)
    if bearings == 0:
        return found
    near = 0.4
    for i in range(first, min(last, n)):
        cos, sin = math.cos(yaws[i]), math.sin(yaws[i])
        x0, y0 = points[i, 0] - offsets[i] * sin, points[i, 1] + offsets[i] * cos
        for side in (1.0, -1.0):
            h = 0.0
            while h <= reach_m:
                x = x0 - side * (half_m + h) * sin
                y = y0 + side * (half_m + h) * cos
                if _is_solid(solid, x, y, near):
                    break
                dx, dy = x - view[0], y - view[1]
                distance = math.hypot(dx, dy)
                bearing = math.atan2(dy, dx) - view[2]
                k = math.floor((bearing + math.pi) / (2.0 * math.pi) * bearings) % bearings
                if distance > ranges[k] + 0.5:
                    if h < found[i, H_BESIDE]:
                        share = ranges[k] / distance
                        cx, cy = view[0] + share * dx - x0, view[1] + share * dy - y0
                        found[i, H_BESIDE] = h
                        found[i, H_CORNER_BEFORE] = max(-(cos * cx + sin * cy), 0.05)
                        found[i, H_CORNER_BESIDE] = max(side * (-sin * cx + cos * cy), half_m)
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
    hidden: Array,
    step_m: float,
    front_m: float,
    sensor_behind_m: float,
    half_m: float,
    run_mps: float,
    react_s: float,
    decel_mps2: float,
    least_mps: float,
    cap_mps: float,
) -> Array:
    """(n,) speed limit of the rear axle from `hidden_beside`.

    sensor_behind_m: from the bumper back to the sensor
    """
    n = hidden.shape[0]
    limits = np.full(n, cap_mps)
    braking_m = cap_mps * react_s + cap_mps * cap_mps / (2.0 * decel_mps2)
    for i in range(n):
        if not np.isfinite(hidden[i, H_BESIDE]):
            continue
        before, beside = hidden[i, H_CORNER_BEFORE], hidden[i, H_CORNER_BESIDE]
        to_i = i - math.floor(front_m / step_m)
        for k in range(max(0, to_i - math.ceil(braking_m / step_m)), max(0, min(n, to_i + 1))):
            togo_m = (to_i - k) * step_m
            eye_m = togo_m + sensor_behind_m
            # The sight past the corner, at the place's own station; level with the corner all is seen.
            if eye_m <= before + 0.1:
                continue
            seen_m = beside * eye_m / (eye_m - before) - half_m
            arrives_s = max(seen_m, 0.0) / run_mps
            stops_mps = decel_mps2 * (math.sqrt(react_s * react_s + 2.0 * togo_m / decel_mps2) - react_s)
            if stops_mps * arrives_s < togo_m:
                limits[k] = min(limits[k], max(stops_mps, least_mps))
    return limits
