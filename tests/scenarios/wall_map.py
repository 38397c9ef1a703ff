"""A point map of a campus's walls, as mapping would find it in the simulated world without a scene."""

from pathlib import Path

import numpy as np

from contract.geometry import Array
from contract.point_map.map_files import PointMapIndex, write_tiles
from contract.point_map.tiles import Surfels
from contract.roads.model import RoadMap

TILE_M, VOXEL_M = 32.0, 0.5
NEAR_M = 160.0


def walls_as_surfels(road_map: RoadMap, x_m: float, y_m: float) -> dict[tuple[int, int], Surfels]:
    """Tiles with the buildings' walls around a place, as mapping would find them."""
    means: list[Array] = []
    normals: list[Array] = []
    for building in road_map.buildings:
        outline = np.array(building.outline)
        for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            length_m = float(np.hypot(*(b - a)))
            if min(np.hypot(*(a - (x_m, y_m))), np.hypot(*(b - (x_m, y_m)))) > NEAR_M or length_m < 0.1:
                continue
            along = a + np.linspace(0.0, 1.0, max(2, round(length_m / 0.25)))[:, None] * (b - a)
            heights = np.arange(0.1, min(building.height_m, 12.0), 0.5)
            means.append(np.column_stack((np.repeat(along, len(heights), 0), np.tile(heights, len(along)))))
            across = np.array([(b - a)[1], -(b - a)[0], 0.0]) / length_m
            normals.append(np.tile(across, (len(means[-1]), 1)))
    mean, normal = np.concatenate(means), np.concatenate(normals)
    _, first = np.unique(np.floor(mean / VOXEL_M).astype(int), axis=0, return_index=True)
    mean, normal = mean[first], normal[first]
    at = np.floor(mean[:, :2] / TILE_M).astype(int)
    tiles = {}
    for ix, iy in np.unique(at, axis=0).tolist():
        chosen = (at == (ix, iy)).all(axis=1)
        count = int(chosen.sum())
        tiles[(ix, iy)] = Surfels(mean[chosen], normal[chosen], np.full(count, 0.02), np.full(count, 9.0))
    return tiles


def write_wall_map(folder: Path, road_map: RoadMap, x_m: float, y_m: float) -> PointMapIndex:
    """The walls around a place, as a point map in a new folder."""
    return write_tiles(folder, walls_as_surfels(road_map, x_m, y_m), TILE_M, VOXEL_M, road_map.origin)
