"""Kernels of the ground's heights: some places are asked for in every step of every vehicle."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array

Grid = NDArray[np.float32]


@njit(cache=True)
def hill_m(x: float, y: float, hills: Array) -> float:
    """Height of the hills; hills (k, 4): wave numbers along x and y, phase, amplitude."""
    height = 0.0
    for k in range(hills.shape[0]):
        height += hills[k, 3] * math.sin(hills[k, 0] * x + hills[k, 1] * y + hills[k, 2])
    return height


@njit(cache=True)
def edge_m(x: float, y: float, corner: Array, cell_m: float, grid: Grid) -> float:
    """Distance to the road's edge between the grid's nodes, positive on the road."""
    u = min(max((x - corner[0]) / cell_m, 0.0), grid.shape[1] - 1.001)
    v = min(max((y - corner[1]) / cell_m, 0.0), grid.shape[0] - 1.001)
    i, j = int(u), int(v)
    fu, fv = u - i, v - j
    low = (1.0 - fu) * grid[j, i] + fu * grid[j, i + 1]
    high = (1.0 - fu) * grid[j + 1, i] + fu * grid[j + 1, i + 1]
    return float((1.0 - fv) * low + fv * high)


@njit(cache=True)
def hills_at(x: Array, y: Array, hills: Array) -> Array:
    """(n,) heights of the hills."""
    heights = np.empty(x.shape[0])
    for k in range(x.shape[0]):
        heights[k] = hill_m(x[k], y[k], hills)
    return heights


@njit(cache=True)
def edges_at(x: Array, y: Array, corner: Array, cell_m: float, grid: Grid) -> Array:
    """(n,) distances to the road's edge."""
    distances = np.empty(x.shape[0])
    for k in range(x.shape[0]):
        distances[k] = edge_m(x[k], y[k], corner, cell_m, grid)
    return distances


@njit(cache=True)
def wheel_poses(
    poses_map: Array,
    wheelbase_m: float,
    track_m: float,
    hills: Array,
    corner: Array,
    cell_m: float,
    grid: Grid,
    crown: tuple[float, float],
) -> Array:
    """(n, 4, 4) T_map_base as `Ground.poses` tells; crown: fall, and the depth at which it ends."""
    count = poses_map.shape[0]
    out = np.zeros((count, 4, 4))
    for k in range(count):
        x, y = poses_map[k, 0], poses_map[k, 1]
        cos, sin = math.cos(poses_map[k, 2]), math.sin(poses_map[k, 2])
        # Left rear, right rear, left front, right front.
        wheels = np.empty(4)
        for w in range(4):
            ahead = wheelbase_m if w >= 2 else 0.0
            left = 0.5 * track_m if w % 2 == 0 else -0.5 * track_m
            wx, wy = x + ahead * cos - left * sin, y + ahead * sin + left * cos
            depth = min(max(edge_m(wx, wy, corner, cell_m, grid), 0.0), crown[1])
            wheels[w] = hill_m(wx, wy, hills) + crown[0] * depth
        rear = 0.5 * (wheels[0] + wheels[1])
        along = (0.5 * (wheels[2] + wheels[3]) - rear) / wheelbase_m
        across = 0.5 * (wheels[0] + wheels[2] - wheels[1] - wheels[3]) / track_m
        length = math.sqrt(1.0 + along * along)
        a0, a1, a2 = cos / length, sin / length, along / length
        # First axis x (-sin, cos, across) gives the one that points up.
        u0, u1, u2 = a1 * across - a2 * cos, -a2 * sin - a0 * across, a0 * cos + a1 * sin
        length = math.sqrt(u0 * u0 + u1 * u1 + u2 * u2)
        u0, u1, u2 = u0 / length, u1 / length, u2 / length
        out[k, 0, 0], out[k, 1, 0], out[k, 2, 0] = a0, a1, a2
        out[k, 0, 1], out[k, 1, 1], out[k, 2, 1] = u1 * a2 - u2 * a1, u2 * a0 - u0 * a2, u0 * a1 - u1 * a0
        out[k, 0, 2], out[k, 1, 2], out[k, 2, 2] = u0, u1, u2
        out[k, 0, 3], out[k, 1, 3], out[k, 2, 3], out[k, 3, 3] = x, y, rear, 1.0
    return out
