"""Hits to returns: detection, range noise and intensity by material, slant and range."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from simulator.sensors.lidars.response import (
    R_BLOOM,
    R_DIVERGENCE,
    R_DROPOUT,
    R_EXTINCTION,
    R_RAIN_CLUTTER,
    R_RAIN_STD,
    R_RANGE_10,
    R_RANGE_MAX,
    R_RANGE_MIN,
    R_RANGE_STD,
    R_SWAY,
)
from simulator.sensors.scene.materials import Material

Array32 = NDArray[np.float32]
_GLASS, _FOLIAGE, _RETRO = int(Material.GLASS), int(Material.FOLIAGE), int(Material.RETRO)
# A pane shines back only within some degrees of right angles.
_GLASS_COS = 0.995
_FOLIAGE_STD_M = 0.02
_BLOOM_STEPS = 3
_BLOOM_INTENSITY = 12.0
_RETRO_FROM = 101.0


@njit(cache=True)
def answer(
    rays: NDArray[np.int64],
    count: int,
    hit_m: Array32,
    triangles: NDArray[np.int32],
    ray_directions: Array32,
    normals: Array32,
    materials: NDArray[np.uint8],
    reflectivity: Array32,
    objects: NDArray[np.int32],
    sway_phases: Array32,
    wind_rad: float,
    params: Array32,
    noise: Array32,
    chance: Array32,
    ranges: Array32,
    intensities: Array32,
) -> None:
    """Write ranges (n,) and intensities (n,) of the firings that return; 0.0 where none does.

    rays (count,), hit_m, triangles, ray_directions (count, 3): as cast; triangles -1 for no hit
    normals, materials, reflectivity, objects: of the scene's triangles
    sway_phases (objects,), wind_rad: where in its swing each tree is
    noise (n, 2) standard normal, chance (n, 2) uniform 0..1, of every firing
    """
    for j in range(count):
        k, t = rays[j], triangles[j]
        ranges[k] = 0.0
        intensities[k] = 0.0
        if params[R_RAIN_CLUTTER] > 0.0 and chance[k, 1] < params[R_RAIN_CLUTTER]:
            # A drop near the sensor answers in place of what is behind it.
            drop = params[R_RANGE_MIN] + 0.5 + 8.0 * chance[k, 0] * chance[k, 0]
            if t < 0 or drop < hit_m[j]:
                ranges[k] = drop
                intensities[k] = 1.0
                continue
        if t < 0 or chance[k, 0] < params[R_DROPOUT]:
            continue
        r = hit_m[j]
        if r < params[R_RANGE_MIN]:
            continue
        slant = abs(
            ray_directions[j, 0] * normals[t, 0]
            + ray_directions[j, 1] * normals[t, 1]
            + ray_directions[j, 2] * normals[t, 2]
        )
        slant = max(slant, np.float32(0.02))
        material = materials[t]
        bright = reflectivity[t] * slant
        if material == _GLASS and slant > _GLASS_COS:
            bright = np.float32(1.0)
        if material == _RETRO:
            bright = np.float32(30.0) * reflectivity[t] * slant
        through = math.exp(-2.0 * params[R_EXTINCTION] * r) if params[R_EXTINCTION] > 0.0 else 1.0
        gain = params[R_RANGE_10] / r
        signal = 10.0 * bright * through * gain * gain
        # Every second return is detected at a signal of 1, 94 % at 2.
        squared = signal * signal
        missed = 1.0 / (1.0 + squared * squared)
        if chance[k, 1] < missed:
            continue
        std = params[R_RANGE_STD] * math.sqrt(1.0 + 1.0 / signal)
        spot = 0.08 * r * params[R_DIVERGENCE] * math.sqrt(1.0 - min(1.0, slant * slant)) / slant
        std = math.sqrt(std * std + min(spot, 0.2) ** 2 + (params[R_RAIN_STD] * r) ** 2)
        measured = r + noise[k, 0] * std
        if material == _FOLIAGE:
            # Of the crown's movement only what is along the ray changes the range.
            phase = wind_rad + sway_phases[max(objects[t], 0)]
            sway = params[R_SWAY] * math.sin(phase) * ray_directions[j, 0]
            sway += params[R_SWAY] * math.cos(1.3 * phase) * ray_directions[j, 1]
            measured += 1.4 * sway + _FOLIAGE_STD_M * noise[k, 1]
        if not params[R_RANGE_MIN] <= measured <= params[R_RANGE_MAX]:
            continue
        ranges[k] = measured
        if material == _RETRO:
            value = _RETRO_FROM + 154.0 * min(1.0, slant * reflectivity[t] * 1.3 * through)
        else:
            value = min(100.0, 100.0 * bright * through * (1.0 + 0.06 * noise[k, 1]))
        intensities[k] = max(np.float32(1.0), np.float32(math.floor(value)))


@njit(cache=True)
def bloom(
    channels: int,
    params: Array32,
    chance: Array32,
    own_ranges: Array32,
    ranges: Array32,
    intensities: Array32,
    bloomed: Array32,
) -> int:
    """Give firings beside a retro-reflector its range, as its light spreads in the optics; return how many.

    All (n,), column after column of `channels` firings; bloomed gets a copy of ranges. A near reflector
    spreads more.
    """
    n = ranges.shape[0]
    ghosts = 0
    for k in range(n):
        bloomed[k] = ranges[k]
    for k in range(n):
        if intensities[k] <= _RETRO_FROM or ranges[k] <= 0.0:
            continue
        steps = 1 + int(min(np.float32(_BLOOM_STEPS - 1), 20.0 / ranges[k]))
        for step in range(-steps, steps + 1):
            other = k + step * channels
            if other < 0 or other >= n or own_ranges[other] > 0.0 or intensities[other] > _RETRO_FROM:
                continue
            is_behind = ranges[other] == 0.0 or ranges[other] > ranges[k] + 0.3
            if is_behind and chance[other, 0] < params[R_BLOOM] / (1.0 + abs(step)):
                bloomed[other] = ranges[k]
                intensities[other] = _BLOOM_INTENSITY / abs(step)
                ghosts += 1
    for k in range(n):
        ranges[k] = bloomed[k]
    return ghosts


@njit(cache=True)
def pack(
    ranges: Array32,
    intensities: Array32,
    directions: Array32,
    offsets_ns: NDArray[np.int64],
    rings: NDArray[np.uint16],
    mount: Array32,
) -> tuple[Array32, Array32, Array32, NDArray[np.uint16], NDArray[np.int64]]:
    """(points_sensor (m, 3), points_base (m, 3), intensities, rings, offsets_ns) of the firings that return.

    mount (3, 4): T_base_sensor
    """
    m = 0
    for k in range(ranges.shape[0]):
        if ranges[k] > 0.0:
            m += 1
    points = np.empty((m, 3), dtype=np.float32)
    based = np.empty((m, 3), dtype=np.float32)
    values = np.empty(m, dtype=np.float32)
    beams = np.empty(m, dtype=np.uint16)
    times = np.empty(m, dtype=np.int64)
    j = 0
    for k in range(ranges.shape[0]):
        reach = ranges[k]
        if reach <= 0.0:
            continue
        x, y, z = reach * directions[k, 0], reach * directions[k, 1], reach * directions[k, 2]
        points[j, 0], points[j, 1], points[j, 2] = x, y, z
        for r in range(3):
            based[j, r] = mount[r, 0] * x + mount[r, 1] * y + mount[r, 2] * z + mount[r, 3]
        values[j], beams[j], times[j] = intensities[k], rings[k], offsets_ns[k]
        j += 1
    return points, based, values, beams, times
