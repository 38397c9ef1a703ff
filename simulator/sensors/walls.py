"""The buildings of a map as a ray-casting scene.

Walls are upright, so all rays of one azimuth meet them in the same horizontal distance: one level ray a
column finds the nearest wall, and only the few rays that pass over its top are cast on their own.
"""

import math

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from contract.roads.model import Building
from simulator.sensors.ray_hits import TWO_PI, WALL, Array32, Kinds

Indices = NDArray[np.int64]

# Level rays run just above the ground, where every wall begins.
_LEVEL_M = 0.05
_TRIANGLES_OF_A_WALL = 2


class WallScene:
    """Walls of extruded outlines, built once; roofs are above every sensor and left out."""

    def __init__(self, buildings: tuple[Building, ...]) -> None:
        triangles = [triangle for building in buildings for triangle in _walls(building)]
        tops = [building.height_m for building in buildings for _ in building.outline]
        self._tops: Array = np.array(tops, dtype=np.float64)
        self._scene: EmbreeScene | None = None
        if triangles:
            self._scene = EmbreeScene()
            self._mesh = TriangleMesh(self._scene, np.array(triangles, dtype=np.float32))

    def shorten(
        self, sensor: Array, yaw_rad: float, cos_el: Array, sin_el: Array, ranges: Array32, kinds: Kinds
    ) -> None:
        """Shorten the ranges of a fan at walls; sensor (3,) in the map frame."""
        if self._scene is None:
            return
        columns = len(ranges) // len(cos_el)
        level: Array32 = np.empty((columns, 3), dtype=np.float32)
        _level_directions(yaw_rad, level)
        hits = self._scene.run(
            _origins(columns, sensor[0], sensor[1], _LEVEL_M),
            level,
            np.full(columns, ranges.max(), dtype=np.float32),
            query="INTERSECT",
            output=1,
        )
        over = _hit_walls(
            hits["tfar"], hits["primID"], self._tops, float(sensor[2]), cos_el, sin_el, ranges, kinds
        )
        if len(over):
            self._cast(over, sensor, level, cos_el, sin_el, ranges, kinds)

    def _cast(
        self,
        rays: Indices,
        sensor: Array,
        level: Array32,
        cos_el: Array,
        sin_el: Array,
        ranges: Array32,
        kinds: Kinds,
    ) -> None:
        assert self._scene is not None
        rings, columns = np.divmod(rays, len(level))
        directions = np.empty((len(rays), 3), dtype=np.float32)
        directions[:, :2] = level[columns, :2] * cos_el[rings, None]
        directions[:, 2] = sin_el[rings]
        reach = ranges[rays]
        found = self._scene.run(_origins(len(rays), *sensor), directions, reach.copy(), query="DISTANCE")
        nearer = found < reach
        ranges[rays[nearer]] = found[nearer]
        kinds[rays[nearer]] = WALL


def _origins(count: int, x_m: float, y_m: float, z_m: float) -> Array32:
    origins: Array32 = np.empty((count, 3), dtype=np.float32)
    origins[:] = (x_m, y_m, z_m)
    return origins


@njit(cache=True)
def _level_directions(yaw_rad: float, out: Array32) -> None:
    for c in range(out.shape[0]):
        azimuth = yaw_rad + TWO_PI * c / out.shape[0]
        out[c, 0], out[c, 1], out[c, 2] = math.cos(azimuth), math.sin(azimuth), 0.0


@njit(cache=True)
def _hit_walls(
    distances: Array32,
    triangles: NDArray[np.int32],
    tops: Array,
    height_m: float,
    cos_el: Array,
    sin_el: Array,
    ranges: Array32,
    kinds: Kinds,
) -> Indices:
    """Shorten the rays that hit the nearest wall of their column. Returns the indices of rays above it."""
    columns = distances.shape[0]
    over = np.empty(ranges.shape[0], dtype=np.int64)
    count = 0
    for c in range(columns):
        if triangles[c] < 0:
            continue
        top_m = tops[triangles[c] // _TRIANGLES_OF_A_WALL]
        for r in range(cos_el.shape[0]):
            k = r * columns + c
            reach = distances[c] / cos_el[r]
            if reach >= ranges[k]:
                continue
            if height_m + reach * sin_el[r] > top_m:
                over[count] = k
                count += 1
            else:
                ranges[k] = reach
                kinds[k] = WALL
    return over[:count].copy()


def _walls(building: Building) -> list[list[tuple[float, float, float]]]:
    outline, top = building.outline, building.height_m
    triangles = []
    for (ax, ay), (bx, by) in zip(outline, outline[1:] + outline[:1], strict=True):
        triangles.append([(ax, ay, 0.0), (bx, by, 0.0), (bx, by, top)])
        triangles.append([(ax, ay, 0.0), (bx, by, top), (ax, ay, top)])
    return triangles
