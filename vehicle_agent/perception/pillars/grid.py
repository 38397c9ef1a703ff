"""Pillars of a scan: the returns over each square of ground, as the detector's network takes them."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array32 = NDArray[np.float32]
Ints = NDArray[np.int64]

FEATURES = 9
# The network's output has one cell for so many pillars along each axis.
STRIDE = 2


class PillarGrid(NamedTuple):
    """What the network sees. A tuple, so that kernels take it.

    x_m_min, y_m_min  the corner behind on the right, base frame; cell_m: a pillar's side
    nx, ny            pillars along x and y; multiples of 8
    points_max        returns of a pillar that are used; of more, some are drawn
    pillars_max       pillars of a scan; those that come later in the scan are left out
    """

    x_m_min: float = -16.0
    y_m_min: float = -20.0
    cell_m: float = 0.2
    nx: int = 280
    ny: int = 200
    points_max: int = 16
    pillars_max: int = 12_000

    @property
    def x_m_max(self) -> float:
        return self.x_m_min + self.nx * self.cell_m

    @property
    def y_m_max(self) -> float:
        return self.y_m_min + self.ny * self.cell_m


class Pillars(NamedTuple):
    """features (p, points_max, FEATURES) and cells (p,): the square, row by row along y.

    The older turn's squares come after all of the newer's. A pillar with fewer returns repeats its first one.
    """

    features: Array32
    cells: Ints


def pillars_of(
    points: Array32,
    is_older: NDArray[np.bool_],
    grid: PillarGrid,
    rng: np.random.Generator | None = None,
) -> Pillars:
    """Pillars of returns that stand above the ground.

    points    (n, 4) x, y (base frame, m), height above the ground (m), intensity 0 to 255
    is_older  (n,) of the turn before, moved to the same frame
    rng       draws which returns of a full pillar are used (Snow Lion, 3D perception); without it they are
              taken at even intervals, so that the same scan gives the same objects
    """
    chance = np.empty(0, dtype=np.float32) if rng is None else rng.random(len(points), dtype=np.float32)
    features, cells = _pillars(
        np.ascontiguousarray(points, dtype=np.float32), np.ascontiguousarray(is_older), grid, chance
    )
    return Pillars(features, cells)


@njit(cache=True)
def _pillars(
    points: Array32, is_older: NDArray[np.bool_], grid: PillarGrid, chance: Array32
) -> tuple[Array32, Ints]:
    n, squares = points.shape[0], grid.nx * grid.ny
    number_of = np.full(2 * squares, -1, np.int32)
    pillar_of = np.full(n, -1, np.int32)
    cells = np.empty(grid.pillars_max, np.int64)
    counts = np.zeros(grid.pillars_max, np.int64)
    sums = np.zeros((grid.pillars_max, 3), np.float64)
    found = 0
    for k in range(n):
        u = (points[k, 0] - grid.x_m_min) / grid.cell_m
        v = (points[k, 1] - grid.y_m_min) / grid.cell_m
        if not (0.0 <= u < grid.nx and 0.0 <= v < grid.ny):
            continue
        cell = int(v) * grid.nx + int(u)
        if is_older[k]:
            cell += squares
        number = number_of[cell]
        if number < 0:
            if found == grid.pillars_max:
                continue
            number = found
            number_of[cell] = number
            cells[number] = cell
            found += 1
        pillar_of[k] = number
        counts[number] += 1
        for axis in range(3):
            sums[number, axis] += points[k, axis]
    features = np.empty((found, grid.points_max, FEATURES), np.float32)
    passed = np.zeros(found, np.int64)
    kept = np.zeros(found, np.int64)
    for k in range(n):
        number = pillar_of[k]
        if number < 0:
            continue
        count, before = counts[number], passed[number]
        passed[number] += 1
        if count > grid.points_max:
            if chance.shape[0] > 0:
                # Knuth, The Art of Computer Programming 3.4.2, algorithm S: every choice is as likely.
                if chance[k] * (count - before) >= grid.points_max - kept[number]:
                    continue
            elif before * grid.points_max // count == (before + 1) * grid.points_max // count:
                continue
        row = features[number, kept[number]]
        kept[number] += 1
        cell = cells[number] % squares
        x, y, height = points[k, 0], points[k, 1], points[k, 2]
        row[0] = (x - grid.x_m_min) / grid.cell_m - (cell % grid.nx + 0.5)
        row[1] = (y - grid.y_m_min) / grid.cell_m - (cell // grid.nx + 0.5)
        row[2] = (x - sums[number, 0] / count) / grid.cell_m
        row[3] = (y - sums[number, 1] / count) / grid.cell_m
        row[4] = height - sums[number, 2] / count
        row[5] = height
        row[6] = min(np.float32(255.0), points[k, 3]) / 100.0
        row[7] = 0.25 * np.log(np.float32(count))
        row[8] = np.sqrt(x * x + y * y) / 20.0
    for number in range(found):
        for slot in range(kept[number], grid.points_max):
            features[number, slot] = features[number, 0]
    return features, cells[:found].copy()
