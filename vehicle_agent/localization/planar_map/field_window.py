"""The likelihood field of the tiles around the vehicle, so that a map of any size costs the same."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np

from contract.geometry import Array
from contract.occupancy.occupancy_map import FREE, UNKNOWN, Cells, OccupancyMap
from vehicle_agent.localization.monte_carlo.likelihood_field import (
    FieldParams,
    LikelihoodField,
    likelihood_field,
)

# The cells of tile (ix, iy), or None where the map has none. It may read a file.
OccupancySource = Callable[[int, int], Cells | None]


@dataclass(frozen=True, slots=True)
class OccupancyTiles:
    """A map by tiles: tile (ix, iy) begins at (ix * tile_m, iy * tile_m) of the map frame."""

    source: OccupancySource
    tile_m: float
    cell_m: float

    @property
    def side(self) -> int:
        """Cells along a tile's edge."""
        return round(self.tile_m / self.cell_m)


class FieldWindow:
    """The field of `around` tiles on each side of the vehicle's own; computed when it enters another one."""

    def __init__(self, tiles: OccupancyTiles, params: FieldParams, around: int) -> None:
        self._tiles, self._params, self._around = tiles, params, around
        self._at: tuple[int, int] | None = None
        self._cache: dict[tuple[int, int], Cells | None] = {}
        self._field: LikelihoodField | None = None

    def around(self, x_m: float, y_m: float) -> LikelihoodField | None:
        """The field about a place; None where the map has no free cell there."""
        tile_m = self._tiles.tile_m
        at = (math.floor(x_m / tile_m), math.floor(y_m / tile_m))
        if at != self._at:
            self._field, self._at = self._computed(at), at
        return self._field

    def _computed(self, at: tuple[int, int]) -> LikelihoodField | None:
        side, around = self._tiles.side, self._around
        places = [
            (at[0] + dx, at[1] + dy) for dy in range(-around, around + 1) for dx in range(-around, around + 1)
        ]
        self._cache = {
            place: self._cache[place] if place in self._cache else self._tiles.source(*place)
            for place in places
        }
        span = 2 * around + 1
        cells: Cells = np.full((span * side, span * side), UNKNOWN, dtype=np.uint8)
        for number, place in enumerate(places):
            tile = self._cache[place]
            if tile is not None:
                row, column = number // span * side, number % span * side
                cells[row : row + side, column : column + side] = tile
        if not (cells == FREE).any():
            return None
        corner = ((at[0] - around) * self._tiles.tile_m, (at[1] - around) * self._tiles.tile_m)
        return likelihood_field(OccupancyMap(cells, self._tiles.cell_m, *corner), self._params)


def free_near(field: LikelihoodField, x_m: float, y_m: float, reach_m: float) -> LikelihoodField:
    """The field with the free cells near a place alone: what a search may take for the vehicle's place."""
    near: Array = field.free[np.hypot(field.free[:, 0] - x_m, field.free[:, 1] - y_m) <= reach_m]
    return msgspec.structs.replace(field, free=near)
