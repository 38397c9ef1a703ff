"""Which rays pass which bodies: rays that fire one after the other are asked together, as a bundle."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.scene.static_scene import Array32

Ints = NDArray[np.int64]
_BUNDLE = 64
# Columns of a bundle's bounds: middle of its origins, axis of its directions, outward normals of the two
# upright planes that its rays lie between (zero where they go all round), cosine and sine of the greatest
# angle to the axis, greatest distance of an origin to the middle, farthest reach.
_MIDDLE, _AXIS, _LEFT, _RIGHT, _COS, _SIN, _SPREAD, _REACH = 0, 3, 6, 8, 10, 11, 12, 13
_BOUNDS = 14
# Ranges and directions are float32.
_SLACK_RAD = 1e-3


@njit(cache=True)
def _bounds_of(origins: Array32, directions: Array32, reach_m: Array32) -> Array:
    """(bundles, _BOUNDS) what the rays of each bundle stay within."""
    count = origins.shape[0]
    bundles = (count + _BUNDLE - 1) // _BUNDLE
    bounds = np.zeros((bundles, _BOUNDS))
    for c in range(bundles):
        begin, end = c * _BUNDLE, min(count, (c + 1) * _BUNDLE)
        own = bounds[c]
        for k in range(begin, end):
            for r in range(3):
                own[_MIDDLE + r] += origins[k, r] / (end - begin)
                own[_AXIS + r] += directions[k, r]
            own[_REACH] = max(own[_REACH], float(reach_m[k]))
        length = math.sqrt(own[_AXIS] ** 2 + own[_AXIS + 1] ** 2 + own[_AXIS + 2] ** 2)
        flat = math.hypot(own[_AXIS], own[_AXIS + 1])
        ax, ay = own[_AXIS] / max(flat, 1e-6), own[_AXIS + 1] / max(flat, 1e-6)
        for r in range(3):
            own[_AXIS + r] /= max(length, 1e-6)
        least, low, high = 1.0, 0.0, 0.0
        is_wedge = flat > 1e-6
        for k in range(begin, end):
            along, apart = 0.0, 0.0
            for r in range(3):
                along += directions[k, r] * own[_AXIS + r]
                apart += (origins[k, r] - own[_MIDDLE + r]) ** 2
            least = min(least, along)
            own[_SPREAD] = max(own[_SPREAD], apart)
            ahead = ax * directions[k, 0] + ay * directions[k, 1]
            aside = ax * directions[k, 1] - ay * directions[k, 0]
            if ahead > 1e-6:
                low, high = min(low, aside / ahead), max(high, aside / ahead)
            elif abs(aside) > 1e-6:
                is_wedge = False
        own[_SPREAD] = math.sqrt(own[_SPREAD])
        # Directions all round have no axis: they are bounded by nothing.
        angle = min(math.acos(max(-1.0, least)) + _SLACK_RAD, math.pi) if length > 1e-6 else math.pi
        own[_COS], own[_SIN] = math.cos(angle), math.sin(angle)
        if is_wedge:
            x, y = ax - ay * high, ay + ax * high
            own[_LEFT], own[_LEFT + 1] = -y / math.hypot(x, y), x / math.hypot(x, y)
            x, y = ax - ay * low, ay + ax * low
            own[_RIGHT], own[_RIGHT + 1] = y / math.hypot(x, y), -x / math.hypot(x, y)
    return bounds


@njit(cache=True)
def _may_meet(own: Array, x: float, y: float, z: float, radius: float) -> bool:
    """Whether a ray of the bundle may meet the sphere."""
    dx, dy, dz = x - own[_MIDDLE], y - own[_MIDDLE + 1], z - own[_MIDDLE + 2]
    away = math.sqrt(dx * dx + dy * dy + dz * dz)
    wide = radius + own[_SPREAD]
    if away - wide > own[_REACH]:
        return False
    if away <= wide:
        return True
    beside = max(own[_LEFT] * dx + own[_LEFT + 1] * dy, own[_RIGHT] * dx + own[_RIGHT + 1] * dy)
    if beside > wide + _SLACK_RAD * away:
        return False
    # The angle to the axis against the sum of the cone's and the sphere's, by their cosines.
    sin = wide / away
    cos = math.sqrt(1.0 - sin * sin)
    along = dx * own[_AXIS] + dy * own[_AXIS + 1] + dz * own[_AXIS + 2]
    return bool(own[_COS] <= -cos or along >= away * (own[_COS] * cos - own[_SIN] * sin))


@njit(cache=True)
def passing(origins: Array32, directions: Array32, reach_m: Array32, spheres: Array) -> tuple[Ints, Ints]:
    """(rays, bodies): every pair of a ray and a sphere that it meets within its reach, body after body."""
    count = origins.shape[0]
    bounds = _bounds_of(origins, directions, reach_m)
    rays, bodies = np.empty(256, dtype=np.int64), np.empty(256, dtype=np.int64)
    found = 0
    for b in range(spheres.shape[0]):
        sx, sy, sz, radius = spheres[b, 0], spheres[b, 1], spheres[b, 2], spheres[b, 3]
        for c in range(bounds.shape[0]):
            if not _may_meet(bounds[c], sx, sy, sz, radius):
                continue
            for k in range(c * _BUNDLE, min(count, (c + 1) * _BUNDLE)):
                dx, dy, dz = sx - origins[k, 0], sy - origins[k, 1], sz - origins[k, 2]
                along = dx * directions[k, 0] + dy * directions[k, 1] + dz * directions[k, 2]
                if along < -radius or along - radius > reach_m[k]:
                    continue
                if dx * dx + dy * dy + dz * dz - along * along > radius * radius:
                    continue
                if found == rays.shape[0]:
                    rays = np.concatenate((rays, np.empty_like(rays)))
                    bodies = np.concatenate((bodies, np.empty_like(bodies)))
                rays[found], bodies[found] = k, b
                found += 1
    return rays[:found], bodies[:found]
