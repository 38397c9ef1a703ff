"""The buildings of a map as walls: what ends the sight, and what a body may touch."""

import numpy as np

from contract.geometry import Array
from contract.roads.model import Building


def wall_edges(buildings: tuple[Building, ...]) -> Array:
    """(n, 4) x0, y0, x1, y1 of every wall, map frame."""
    walls = [
        (*a, *b)
        for building in buildings
        for a, b in zip(building.outline, building.outline[1:] + building.outline[:1], strict=True)
    ]
    return np.array(walls, dtype=np.float64).reshape(-1, 4)


def edges_near(edges: Array, x_m: float, y_m: float, within_m: float) -> Array:
    """Those of the (n, 4) edges whose bounds come within a distance of a place."""
    low = np.minimum(edges[:, :2], edges[:, 2:]) - within_m
    high = np.maximum(edges[:, :2], edges[:, 2:]) + within_m
    place = np.array([x_m, y_m])
    near: Array = edges[((low <= place) & (place <= high)).all(axis=1)]
    return near
