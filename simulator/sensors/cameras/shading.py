"""Light that surfaces send to a camera: diffuse reflection of sun, sky and lamps, with grain."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from simulator.sensors.cameras.colours import GRAIN
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.static_scene import Array32

_GLASS = int(Material.GLASS)
_RETRO = int(Material.RETRO)
# Indices into the row of lights that `light_row` makes.
SUN_X, SUN_Y, SUN_Z, SUN, SKY, LAMP, AXIS_X, AXIS_Y, AXIS_Z, PIXEL_RAD, HAZE_M = range(11)
LIGHT_COLUMNS = 11
_LAMP_CONE = math.cos(math.radians(28.0))


@njit(cache=True)
def _hash(i: int, j: int, k: int) -> float:
    """A number from 0 to 1 of a lattice point."""
    h = (i * 374761393 + j * 668265263 + k * 2147483647) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    h = (h ^ (h >> 16)) & 0xFFFFFF
    return h / 16777215.0


@njit(cache=True)
def _noise(x: float, y: float, z: float) -> float:
    """Value noise, 0 to 1: smooth between the points of a lattice of 1."""
    i, j, k = math.floor(x), math.floor(y), math.floor(z)
    u, v, w = x - i, y - j, z - k
    u, v, w = u * u * (3.0 - 2.0 * u), v * v * (3.0 - 2.0 * v), w * w * (3.0 - 2.0 * w)
    total = 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if c else 1.0 - w)
                total += weight * _hash(int(i) + a, int(j) + b, int(k) + c)
    return total


@njit(cache=True)
def _sky_light(z: float, x: float, y: float, sky: float, rgb: Array32) -> None:
    """The sky in a direction: brighter at the horizon, with clouds."""
    up = max(0.0, z)
    cloud = _noise(3.0 * x / (0.25 + up), 3.0 * y / (0.25 + up), 0.5)
    white = 0.55 + 0.45 * cloud
    rgb[0] = sky * (0.95 * white - 0.35 * up * (1.0 - cloud))
    rgb[1] = sky * (1.0 * white - 0.2 * up * (1.0 - cloud))
    rgb[2] = sky * (1.05 * white)


@njit(cache=True)
def shade(
    rows: NDArray[np.int64],
    hit_m: Array32,
    triangles: NDArray[np.int32],
    origin: Array32,
    rays: Array32,
    lit: NDArray[np.bool_],
    normals: Array32,
    materials: NDArray[np.uint8],
    colours: Array32,
    lights: Array32,
    out: Array32,
) -> None:
    """Write the light (n, 3) of some rays, relative to the white ground under the whole sky.

    rows       (k,) which rays; hit_m, triangles, rays, lit, out have one row for each ray (n)
    triangles  the surface that the ray meets; -1 for the sky
    lit        the sun reaches the surface
    normals, materials, colours  of the scene's triangles
    lights     (11,) as in `SUN_X` and the following; the lamp stands at the camera
    """
    sky, sun, lamp = lights[SKY], lights[SUN], lights[LAMP]
    mirrored = np.empty(3, dtype=np.float32)
    for row in rows:
        x, y, z = rays[row, 0], rays[row, 1], rays[row, 2]
        t = triangles[row]
        if t < 0:
            _sky_light(z, x, y, sky, out[row])
            continue
        reach = hit_m[row]
        nx, ny, nz = normals[t, 0], normals[t, 1], normals[t, 2]
        facing = nx * x + ny * y + nz * z
        if facing > 0.0:
            nx, ny, nz, facing = -nx, -ny, -nz, -facing
        px, py, pz = origin[0] + reach * x, origin[1] + reach * y, origin[2] + reach * z
        material = materials[t]
        grain = 1.0
        if GRAIN[material] > 0.0:
            # The finest grain that a pixel resolves, so that no grain flickers.
            size = 0.03 * 2.0 ** max(
                0.0, math.ceil(math.log2(max(1e-6, 2.5 * reach * lights[PIXEL_RAD] / 0.03)))
            )
            fine = _noise(px / size, py / size, pz / size)
            rough = _noise(0.19 * px / size, 0.19 * py / size, 0.19 * pz / size)
            grain = 1.0 + GRAIN[material] * 2.0 * (0.6 * fine + 0.4 * rough - 0.5)
        # Less of the sky reaches what looks down; the ground returns a little.
        light = sky * (0.62 + 0.38 * nz)
        if lit[row]:
            towards = nx * lights[SUN_X] + ny * lights[SUN_Y] + nz * lights[SUN_Z]
            light += sun * max(0.0, towards)
        if lamp > 0.0:
            along = x * lights[AXIS_X] + y * lights[AXIS_Y] + z * lights[AXIS_Z]
            if along > _LAMP_CONE:
                share = min(1.0, 4.0 * (along - _LAMP_CONE) / (1.0 - _LAMP_CONE))
                strength = lamp * share * (10.0 / max(2.0, reach)) ** 2
                light += strength * (8.0 if material == _RETRO else -facing)
        for c in range(3):
            out[row, c] = colours[t, c] * light * grain
        if material == _GLASS:
            # Fresnel's law after Schlick (1994); the pane mirrors the sky.
            mirror = 0.08 + 0.92 * (1.0 + facing) ** 5
            turned = z - 2.0 * facing * nz
            _sky_light(turned, x - 2.0 * facing * nx, y - 2.0 * facing * ny, sky, mirrored)
            for c in range(3):
                dark = 0.35 if turned < 0.0 else 1.0
                out[row, c] += mirror * dark * mirrored[c]
        if lights[HAZE_M] > 0.0:
            left = math.exp(-reach / lights[HAZE_M])
            for c in range(3):
                out[row, c] = left * out[row, c] + (1.0 - left) * 0.9 * sky
