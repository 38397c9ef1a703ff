"""The occupancy map of a log whose poses are known: how many beams ended in each cell and passed through."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from contract.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN, Cells, OccupancyMap
from workshop.carmen.laser_logs import LaserLog

Counts = NDArray[np.int32]
_CELLS_MAX = 100_000_000


class OccupancyParams(msgspec.Struct, frozen=True):
    """How counts become states.

    range_m_max    longer beams are left out
    step_m, step_rad  a scan counts if the laser moved this far since the last one that counts, so that a
                      standing robot does not draw the people before it
    hits_min       fewer beams that ended in a cell do not make it occupied
    hit_ratio_min  and they must be this share of all that reached it
    passes_min     fewer beams that passed through a cell do not make it free
    """

    cell_m: float = 0.05
    range_m_max: float = 40.0
    step_m: float = 0.05
    step_rad: float = 0.035
    hits_min: int = 2
    hit_ratio_min: float = 0.25
    passes_min: int = 2


class MapTooLarge(ValueError):
    """The poses span more cells than fit into memory."""


def occupancy_map(
    log: LaserLog, poses: Array, params: OccupancyParams, advance: Callable[[int], None]
) -> OccupancyMap:
    """The map in the frame of the laser's poses (n, 3). Raises MapTooLarge."""
    angles_rad = log.beams.angles_rad
    ranges_m = np.where(log.ranges_m <= params.range_m_max, log.ranges_m, np.nan)
    low, high = _extent(poses, ranges_m, angles_rad)
    # Corners on whole cells: equal drives give equal maps.
    first = np.floor(low / params.cell_m) - 1.0
    columns, rows = (int(count) for count in np.ceil(high / params.cell_m) - first + 1.0)
    if rows * columns > _CELLS_MAX:
        raise MapTooLarge(f"The drive spans {high[0] - low[0]:.0f} x {high[1] - low[1]:.0f} m.")
    hits = np.zeros((rows, columns), dtype=np.int32)
    passes = np.zeros((rows, columns), dtype=np.int32)
    counted: Array | None = None
    for number, pose in enumerate(poses):
        advance(1)
        if counted is not None and _is_near(counted, pose, params):
            continue
        counted = pose
        _count(hits, passes, ranges_m[number], angles_rad, pose, first * params.cell_m, params.cell_m)
    cells: Cells = np.full((rows, columns), UNKNOWN, dtype=np.uint8)
    cells[passes >= params.passes_min] = FREE
    reached = hits + passes
    cells[(hits >= params.hits_min) & (hits >= params.hit_ratio_min * reached)] = OCCUPIED
    origin = first * params.cell_m
    return OccupancyMap(cells, params.cell_m, float(origin[0]), float(origin[1]))


def _is_near(counted: Array, pose: Array, params: OccupancyParams) -> bool:
    turn_rad = abs(math.remainder(pose[2] - counted[2], math.tau))
    return math.hypot(*(pose[:2] - counted[:2])) < params.step_m and turn_rad < params.step_rad


def _extent(poses: Array, ranges_m: Array, angles_rad: Array) -> tuple[Array, Array]:
    """(least, greatest) x and y of all poses and beam ends."""
    headings = poses[:, 2, None] + angles_rad[None, :]
    low, high = poses[:, :2].min(axis=0), poses[:, :2].max(axis=0)
    if np.isfinite(ranges_m).any():
        x_m = poses[:, 0, None] + ranges_m * np.cos(headings)
        y_m = poses[:, 1, None] + ranges_m * np.sin(headings)
        low = np.minimum(low, [np.nanmin(x_m), np.nanmin(y_m)])
        high = np.maximum(high, [np.nanmax(x_m), np.nanmax(y_m)])
    return low, high


@njit(cache=True)
def _count(
    hits: Counts,
    passes: Counts,
    ranges_m: Array,
    angles_rad: Array,
    pose: Array,
    origin: Array,
    cell_m: float,
) -> None:
    """Visits the cells of each beam in order (Amanatides and Woo 1987)."""
    x, y = (pose[0] - origin[0]) / cell_m, (pose[1] - origin[1]) / cell_m
    for beam in range(ranges_m.shape[0]):
        if not ranges_m[beam] > 0.0:
            continue
        length = ranges_m[beam] / cell_m
        dx, dy = math.cos(pose[2] + angles_rad[beam]), math.sin(pose[2] + angles_rad[beam])
        column, row = math.floor(x), math.floor(y)
        last_column, last_row = math.floor(x + length * dx), math.floor(y + length * dy)
        step_column, step_row = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
        # Lengths along the beam to the next border, and from border to border.
        per_column = abs(1.0 / dx) if dx != 0.0 else np.inf
        per_row = abs(1.0 / dy) if dy != 0.0 else np.inf
        to_column = ((column + 1 - x) if dx > 0.0 else (x - column)) * per_column if dx != 0.0 else np.inf
        to_row = ((row + 1 - y) if dy > 0.0 else (y - row)) * per_row if dy != 0.0 else np.inf
        remaining = abs(last_column - column) + abs(last_row - row)
        while remaining > 0:
            passes[row, column] += 1
            if to_column < to_row:
                column += step_column
                to_column += per_column
            else:
                row += step_row
                to_row += per_row
            remaining -= 1
        hits[last_row, last_column] += 1
