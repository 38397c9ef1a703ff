"""Scans of boards, ring by ring, as a VLP-16 would give them."""

import math

import numpy as np
import shapely

from contract.geometry import Array

LIDAR_Z_M = 2.2
_STEP_RAD = math.radians(0.2)
_RINGS_RAD = np.radians(np.arange(-15.0, 16.0, 2.0))


def octagon(across_m: float = 0.75) -> Array:
    """(8, 2) corners, y to the left and z up, about the middle."""
    angles = math.pi / 8.0 + math.pi / 4.0 * np.arange(8)
    return 0.5 * across_m / math.cos(math.pi / 8.0) * np.column_stack((np.cos(angles), np.sin(angles)))


def point_down(side_m: float = 0.9) -> Array:
    tall = side_m * math.sqrt(0.75)
    return np.array([[-0.5 * side_m, tall / 3.0], [0.5 * side_m, tall / 3.0], [0.0, -2.0 * tall / 3.0]])


def plate(width_m: float, height_m: float) -> Array:
    w, h = 0.5 * width_m, 0.5 * height_m
    return np.array([[-w, -h], [w, -h], [w, h], [-w, h]])


def returns_of(
    outline: Array,
    middle: tuple[float, float, float],
    turned_rad: float = 0.0,
    noise_m: float = 0.015,
    seed: int = 1,
) -> Array:
    """(n, 3) returns of a board about `middle`, base frame, its normal turned from -x; lidar at x = 0."""
    rng = np.random.default_rng(seed)
    azimuths = np.arange(-1.0, 1.0, _STEP_RAD) + rng.uniform(0.0, _STEP_RAD)
    azimuth, elevation = (axis.ravel() for axis in np.meshgrid(azimuths, _RINGS_RAD))
    rays = np.column_stack(
        (np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation))
    )
    normal = -np.array([math.cos(turned_rad), math.sin(turned_rad)])
    from_lidar = np.array(middle) - [0.0, 0.0, LIDAR_Z_M]
    with np.errstate(divide="ignore"):
        reach = (from_lidar[:2] @ normal) / (rays[:, :2] @ normal)
    hits = rays * reach[:, None]
    across = (hits - from_lidar)[:, :2] @ np.array([-math.sin(turned_rad), math.cos(turned_rad)])
    met = shapely.contains_xy(shapely.Polygon(outline), across, hits[:, 2] - from_lidar[2]) & (reach > 0.0)
    noisy = hits[met] + rays[met] * rng.normal(0.0, noise_m, (int(met.sum()), 1))
    return (noisy + np.array([0.0, 0.0, LIDAR_Z_M])).astype(np.float32)


def ground(seed: int = 2, count: int = 1500) -> Array:
    """(n, 3) returns of a level road."""
    rng = np.random.default_rng(seed)
    return np.column_stack(
        (rng.uniform(3.0, 35.0, count), rng.uniform(-9.0, 9.0, count), np.zeros(count))
    ).astype(np.float32)


def scan_of(*bright: Array) -> tuple[Array, Array]:
    """(points (n, 3), intensities (n,)): the road, and retro-reflecting returns."""
    road = ground()
    points = np.vstack((road, *bright)).astype(np.float32)
    intensities = np.full(len(points), 200.0, np.float32)
    intensities[: len(road)] = 20.0
    return points, intensities
