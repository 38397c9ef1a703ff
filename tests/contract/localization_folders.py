"""Small localization maps in folders, for tests of what sends them around."""

from pathlib import Path

import numpy as np

from contract.occupancy import tile_files as occupancy
from contract.occupancy.occupancy_map import FREE, OCCUPIED
from contract.point_map import map_files as points
from contract.point_map.tiles import Surfels
from contract.roads.model import Origin

TILE_M = 32.0


def point_map(
    folder: Path, origin: Origin | None, tiles: int = 3, changed: int = 0, moved_m: float = 0.5
) -> points.PointMapIndex:
    """A map of walls in a row of tiles, west and east of the origin.

    The first `changed` of them differ from those of another such map.
    """
    surfels = {}
    for number in range(tiles):
        ix = number - 1
        means = np.zeros((20, 3))
        means[:, 0] = ix * TILE_M + np.linspace(1.0, 30.0, 20)
        means[:, 1] = 4.0 + (moved_m if number < changed else 0.0)
        means[:, 2] = 1.0
        normals = np.tile([0.0, 1.0, 0.0], (20, 1))
        surfels[(ix, 0)] = Surfels(means, normals, np.full(20, 0.02), np.full(20, 9.0))
    return points.write_tiles(folder, surfels, TILE_M, 0.5, origin)


def occupancy_map(folder: Path, origin: Origin, tiles: int = 3) -> occupancy.OccupancyTilesIndex:
    """All tiles are equal: one content at several places."""
    cells = np.full((32, 32), FREE, dtype=np.uint8)
    cells[4] = OCCUPIED
    return occupancy.write_tiles(folder, {(ix - 1, 0): cells for ix in range(tiles)}, TILE_M, 1.0, origin)
