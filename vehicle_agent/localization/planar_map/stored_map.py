"""An occupancy map on the vehicle's disk: checked as a whole before a drive, and then read tile by tile."""

from pathlib import Path

from contract.occupancy.occupancy_map import Cells
from contract.occupancy.tile_files import OccupancyTilesIndex, read_index, read_tile
from contract.roads.model import Origin
from vehicle_agent.localization.planar_map.field_window import OccupancyTiles


def checked_index(folder: Path, origin: Origin) -> OccupancyTilesIndex:
    """The index of a map whose every tile is whole, and which lies in the road map's frame.

    Raises OccupancyTilesError: damaged, or of another place.
    """
    index = read_index(folder, origin)
    for entry in index.tiles:
        read_tile(folder, index, entry)
    return index


def stored_tiles(folder: Path, index: OccupancyTilesIndex) -> OccupancyTiles:
    """The map's tiles. Reading one raises OccupancyTilesError if it was damaged since the map was checked."""
    entries = {(entry.ix, entry.iy): entry for entry in index.tiles}

    def cells(ix: int, iy: int) -> Cells | None:
        entry = entries.get((ix, iy))
        return None if entry is None else read_tile(folder, index, entry)

    return OccupancyTiles(cells, index.tile_m, index.cell_m, tuple(sorted(entries)))
