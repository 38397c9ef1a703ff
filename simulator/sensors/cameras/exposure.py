"""From light to a picture: lens, glare, rain, exposure, noise, gamma."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from contract.geometry import Array
from simulator.sensors.cameras.light import Light
from simulator.sensors.scene.static_scene import Array32

_LENS_PX = 0.55
# A camera's own processor sharpens edges and spreads the tones.
_SHARPEN, _SHARPEN_PX, _CONTRAST = 0.6, 1.0, 1.2
# The mean grey that the exposure aims at, linear.
_AIM = 0.20
_VISIBLE_SUN_RAD = 0.9


def developed(
    light: Array32,
    lights: Light,
    sun_px: tuple[float, float] | None,
    sun_angle_rad: float,
    rng: np.random.Generator,
) -> NDArray[np.uint8]:
    """(h, w, 3) uint8 of the light (h, w, 3) that reaches the lens.

    sun_px         where the sun stands in the picture, inside or outside; None if it is behind or hidden
    sun_angle_rad  between the sun and the camera's axis
    """
    picture = gaussian_filter(light, (_LENS_PX, _LENS_PX, 0.0))
    if sun_px is not None and lights.glare_ratio > 0.0 and sun_angle_rad < _VISIBLE_SUN_RAD:
        picture = picture + _glare(picture.shape, lights, sun_px, sun_angle_rad)
    if lights.rain_mm_per_h > 0.0:
        picture = _rain(picture, lights.rain_mm_per_h, rng)
    middle = float(np.mean(np.minimum(picture, 4.0)))
    gain = min(lights.exposure_max, _AIM / max(middle, 1e-6))
    exposed = picture * np.float32(gain)
    encoded = np.where(
        exposed < 0.0031308, 12.92 * exposed, 1.055 * np.maximum(exposed, 1e-9) ** (1 / 2.4) - 0.055
    )
    encoded = encoded + _SHARPEN * (encoded - gaussian_filter(encoded, (_SHARPEN_PX, _SHARPEN_PX, 0.0)))
    encoded = 0.45 + _CONTRAST * (encoded - 0.45)
    noise = lights.noise * (0.5 + 0.5 * math.sqrt(max(1.0, gain)))
    encoded = 255.0 * encoded + noise * rng.standard_normal(picture.shape, dtype=np.float32)
    pixels: NDArray[np.uint8] = np.clip(np.rint(encoded), 0.0, 255.0).astype(np.uint8)
    return pixels


def _glare(shape: tuple[int, ...], lights: Light, sun_px: tuple[float, float], angle_rad: float) -> Array:
    """Scattered light (h, w, 1): a disc around the sun, and a veil over all."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    apart = np.hypot(u - sun_px[0], v - sun_px[1]) / shape[1]
    strength = lights.sun * lights.glare_ratio * (1.0 - angle_rad / _VISIBLE_SUN_RAD)
    veil = strength * (0.8 + 12.0 * np.exp(-((apart / 0.12) ** 2)) + 2.0 * np.exp(-apart / 0.2))
    spread: Array = veil[:, :, None].astype(np.float32)
    return spread


def _rain(picture: Array32, rain_mm_per_h: float, rng: np.random.Generator) -> Array32:
    """Streaks of falling drops, and drops on the lens that blur what is behind them."""
    height, width, _ = picture.shape
    wet = picture.copy()
    bright = 0.25 * float(picture.mean())
    for _ in range(round(6.0 * rain_mm_per_h)):
        u, v = int(rng.integers(width)), int(rng.integers(height))
        wet[v : v + int(rng.integers(6, 22)), u] += bright
    drops = round(0.5 * rain_mm_per_h)
    if drops:
        smooth = gaussian_filter(picture, (6.0, 6.0, 0.0))
        v, u = np.mgrid[:height, :width]
        share = np.zeros((height, width), dtype=np.float32)
        for _ in range(drops):
            radius = float(rng.uniform(4.0, 14.0)) * width / 640.0
            at = rng.uniform((0.0, 0.0), (width, height))
            share = np.maximum(share, np.clip(2.0 - np.hypot(u - at[0], v - at[1]) / radius, 0.0, 1.0))
        wet = wet + share[:, :, None] * (smooth - wet)
    return wet.astype(np.float32)
