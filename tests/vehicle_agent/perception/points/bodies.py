"""Scans of several lidars' density, made of surfaces: what stands on a road."""

import math

import numpy as np

from contract.geometry import Array

GRID_ARGUMENTS = (2.4, 3.5, 0.85, 0.82)


def road(slope: float = 0.0, kerb_y_m: float | None = None, kerb_m: float = 0.12) -> np.ndarray:
    """(n, 3) a road of 30 m x 24 m that rises along x; beyond kerb_y_m it is kerb_m higher."""
    x, y = np.meshgrid(np.arange(-6.0, 24.0, 0.2), np.arange(-12.0, 12.0, 0.2))
    z = slope * x
    if kerb_y_m is not None:
        z = z + np.where(y > kerb_y_m, kerb_m, 0.0)
    return np.column_stack((x.ravel(), y.ravel(), z.ravel()))


def person(
    x: float, y: float, height_m: float = 1.7, radius_m: float = 0.22, low_m: float = 0.05
) -> np.ndarray:
    """(n, 3) the half of an upright body that faces the vehicle."""
    return pillar(x, y, radius_m, low_m, height_m)


def pillar(x: float, y: float, radius_m: float, low_m: float, high_m: float) -> np.ndarray:
    """(n, 3) the half of a cylinder that faces the vehicle, by beams with even angles between them."""
    towards = math.atan2(-y, -x)
    angle, z = np.meshgrid(towards + np.arcsin(np.linspace(-0.98, 0.98, 13)), np.arange(low_m, high_m, 0.06))
    return np.column_stack(
        (x + radius_m * np.cos(angle.ravel()), y + radius_m * np.sin(angle.ravel()), z.ravel())
    )


def sides(x: float, y: float, yaw: float, length: float, width: float, low: float, high: float) -> np.ndarray:
    """(n, 3) the sides of a box that face the vehicle."""
    along, across = np.arange(0.0, length, 0.08) - 0.5 * length, np.arange(0.0, width, 0.08) - 0.5 * width
    edges = [
        (np.column_stack((along, np.full(len(along), sign * 0.5 * width))), (0.0, sign))
        for sign in (-1.0, 1.0)
    ] + [
        (np.column_stack((np.full(len(across), sign * 0.5 * length), across)), (sign, 0.0))
        for sign in (-1.0, 1.0)
    ]
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    heights = np.arange(low, high, 0.1)
    seen: list[Array] = []
    for places, normal in edges:
        faced = turn @ np.array(normal)
        middle = turn @ (0.5 * np.array([length * normal[0], width * normal[1]])) + [x, y]
        if faced @ (np.array([1.3, 0.0]) - middle) <= 0.0:
            continue
        flat = places @ turn.T + [x, y]
        seen.append(np.column_stack((np.repeat(flat, len(heights), axis=0), np.tile(heights, len(flat)))))
    return np.vstack(seen)


def scan(*parts: np.ndarray, noise_m: float = 0.01, seed: int = 1) -> np.ndarray:
    """(n, 3) float32 the parts with noise."""
    points = np.vstack(parts)
    noisy: np.ndarray = (points + np.random.default_rng(seed).normal(0.0, noise_m, points.shape)).astype(
        np.float32
    )
    return noisy
