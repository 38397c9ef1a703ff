"""The map around a place: its tiles and their likelihood field, at the same cost on any campus."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contract.occupancy.occupancy_map import FREE, UNKNOWN, Cells, OccupancyMap
from vehicle_agent.localization.monte_carlo.likelihood_field import (
    FieldParams,
    LikelihoodField,
    likelihood_field,
)

# The cells of tile (ix, iy), or None where the map has none. It may read a file.
OccupancySource = Callable[[int, int], Cells | None]
# Fields that are kept: of the vehicle's own place, and of one or two where it may be instead.
_FIELDS_KEPT = 3
# Tiles that are kept. One has 100 kB in cells of 0.1 m.
_TILES_KEPT = 120


@dataclass(frozen=True, slots=True)
class OccupancyTiles:
    """A map by tiles: tile (ix, iy) begins at (ix * tile_m, iy * tile_m) of the map frame.

    places  of all tiles; empty where they are not known, and the whole map is not searched
    """

    source: OccupancySource
    tile_m: float
    cell_m: float
    places: tuple[tuple[int, int], ...] = ()

    @property
    def side(self) -> int:
        """Cells along a tile's edge."""
        return round(self.tile_m / self.cell_m)


class FieldWindow:
    """The field of a place's tile and `around` more on each side; computed when it changes."""

    def __init__(self, tiles: OccupancyTiles, params: FieldParams, around: int) -> None:
        self.tiles = tiles
        self._params, self._around = params, around
        self._cache: dict[tuple[int, int], Cells | None] = {}
        self._fields: dict[tuple[int, int], LikelihoodField | None] = {}

    def around(self, x_m: float, y_m: float) -> LikelihoodField | None:
        """The field about a place; None where the map has no free cell there."""
        tile_m = self.tiles.tile_m
        at = (math.floor(x_m / tile_m), math.floor(y_m / tile_m))
        # The one that was used last is at the end.
        field = self._fields.pop(at) if at in self._fields else self._computed(at)
        self._fields[at] = field
        while len(self._fields) > _FIELDS_KEPT:
            del self._fields[next(iter(self._fields))]
        return field

    def _computed(self, at: tuple[int, int]) -> LikelihoodField | None:
        first = (at[0] - self._around, at[1] - self._around)
        cells = self.cells(first, (at[0] + self._around, at[1] + self._around))
        if not (cells == FREE).any():
            return None
        corner = (first[0] * self.tiles.tile_m, first[1] * self.tiles.tile_m)
        return likelihood_field(OccupancyMap(cells, self.tiles.cell_m, *corner), self._params)

    def cells(self, first: tuple[int, int], last: tuple[int, int]) -> Cells:
        """The cells of all tiles from one to another, both included; unknown where the map has none."""
        side = self.tiles.side
        columns, rows = last[0] - first[0] + 1, last[1] - first[1] + 1
        cells: Cells = np.full((rows * side, columns * side), UNKNOWN, dtype=np.uint8)
        for iy in range(rows):
            for ix in range(columns):
                tile = self._tile((first[0] + ix, first[1] + iy))
                if tile is not None:
                    cells[iy * side : (iy + 1) * side, ix * side : (ix + 1) * side] = tile
        return cells

    def _tile(self, place: tuple[int, int]) -> Cells | None:
        tile = self._cache.pop(place) if place in self._cache else self.tiles.source(*place)
        self._cache[place] = tile
        while len(self._cache) > _TILES_KEPT:
            del self._cache[next(iter(self._cache))]
        return tile
