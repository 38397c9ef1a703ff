"""Where things stand beside the roads of a map."""

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from contract.geometry import Array
from contract.roads.model import Building
from simulator.sensors.scene.ground import Ground

# An edge that is shorter encloses a gap between lanes, not a verge.
_RING_M_MIN = 60.0
_STEP_M = 1.0
_RASTER_M = 0.5
# Straight on for so far on either side: nothing is parked in a bend.
_STRAIGHT_STEPS = 3


@dataclass(frozen=True, slots=True)
class Footprint:
    """beyond_m: of the thing's middle from the road's edge; half_m, half_across_m: half of what it takes."""

    beyond_m: float
    half_m: float
    half_across_m: float


class RoadSide:
    """Stations along the edges of the roads; what is placed takes its ground.

    stations  (n, 3) x, y, yaw along the edge: the road is on the left, so near traffic drives this way where
              it keeps to the right
    """

    def __init__(self, ground: Ground, buildings: tuple[Building, ...]) -> None:
        self._ground = ground
        lines = []
        for ring in shapely.get_rings(shapely.get_parts(shapely.orient_polygons(ground.road))):
            if ring.length < _RING_M_MIN:
                continue
            at = np.arange(0.5 * _STEP_M, ring.length, _STEP_M)
            places = shapely.get_coordinates(shapely.line_interpolate_point(ring, at))
            ahead = np.roll(places, -1, axis=0) - np.roll(places, 1, axis=0)
            yaw = np.arctan2(ahead[:, 1], ahead[:, 0])
            bend = np.abs(
                np.angle(np.exp(1j * (np.roll(yaw, -_STRAIGHT_STEPS) - np.roll(yaw, _STRAIGHT_STEPS))))
            )
            lines.append(np.column_stack((places, yaw, bend)))
        table = np.vstack(lines) if lines else np.empty((0, 4))
        self.stations: Array = table[:, :3]
        self._is_straight = table[:, 3] < 0.12
        outlines = [shapely.Polygon(b.outline).buffer(0.0) for b in buildings if len(b.outline) >= 3]
        self._walls = shapely.STRtree(outlines)
        rows, columns = ground.inside_m.shape
        self._taken: NDArray[np.bool_] = np.zeros((2 * rows, 2 * columns), dtype=bool)

    def every(self, spacing_m: float, rng: np.random.Generator, share: float = 1.0) -> NDArray[np.int64]:
        """Stations about this far apart along the edges; only a share of them."""
        first = float(rng.uniform(0.0, spacing_m))
        at = np.arange(first, len(self.stations) * _STEP_M, spacing_m)
        at += rng.uniform(-0.3, 0.3, len(at)) * spacing_m
        stations = np.clip((at / _STEP_M).astype(np.int64), 0, max(0, len(self.stations) - 1))
        return stations[rng.random(len(stations)) < share]

    def place(self, stations: NDArray[np.int64], footprint: Footprint, straight: bool = False) -> Array:
        """(k, 3) poses of the stations at which the ground is free; it is taken from then on."""
        if not len(stations):
            return np.empty((0, 3))
        if straight:
            stations = stations[self._is_straight[stations]]
        poses = self.stations[stations].copy()
        poses[:, 0] += footprint.beyond_m * np.sin(poses[:, 2])
        poses[:, 1] -= footprint.beyond_m * np.cos(poses[:, 2])
        reach = math.hypot(footprint.half_m, footprint.half_across_m)
        is_free = np.ones(len(poses), dtype=bool)
        is_free[
            self._walls.query(shapely.points(poses[:, :2]), predicate="dwithin", distance=reach + 0.2)[0]
        ] = False
        offsets = self._offsets(footprint)
        for i in np.flatnonzero(is_free):
            px, py = _moved(poses[i], offsets)
            cells = self._cells(px, py)
            if self._taken[cells].any() or self._ground.inside_at(px, py).max() > -0.05:
                is_free[i] = False
                continue
            self._taken[cells] = True
        return poses[is_free]

    def take(self, poses: Array, footprint: Footprint) -> None:
        """The ground of what has its place already, poses (n, 3)."""
        offsets = self._offsets(footprint)
        for pose in poses:
            self._taken[self._cells(*_moved(pose, offsets))] = True

    def _cells(self, x: Array, y: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        columns = ((x - self._ground.corner[0]) / _RASTER_M).astype(np.int64)
        rows = ((y - self._ground.corner[1]) / _RASTER_M).astype(np.int64)
        return rows, columns

    @staticmethod
    def _offsets(footprint: Footprint) -> Array:
        along = np.linspace(-footprint.half_m, footprint.half_m, 2 + int(4 * footprint.half_m))
        across = np.linspace(
            -footprint.half_across_m, footprint.half_across_m, 2 + int(4 * footprint.half_across_m)
        )
        return np.column_stack([axis.ravel() for axis in np.meshgrid(along, across)])


def _moved(pose: Array, offsets: Array) -> tuple[Array, Array]:
    """((n,), (n,)) x and y of offsets (n, 2) from a pose (3,)."""
    x, y, yaw = pose
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + cos * offsets[:, 0] - sin * offsets[:, 1], y + sin * offsets[:, 0] + cos * offsets[:, 1]
