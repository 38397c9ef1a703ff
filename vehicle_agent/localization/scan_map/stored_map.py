"""A point map on the vehicle's disk: checked as a whole before a drive, and then read tile by tile."""

from pathlib import Path

from contract.localization_maps import is_same_frame
from contract.occupancy.tile_files import OccupancyTilesIndex
from contract.point_map.map_files import PointMapError, PointMapIndex, read_index, read_tile
from contract.point_map.tiles import Surfels
from contract.roads.model import Origin
from vehicle_agent.localization.scan_map.localizer import TileSource


def checked_index(folder: Path, origin: Origin) -> PointMapIndex:
    """The index of a map whose every tile is whole, and which lies in the road map's frame.

    Raises PointMapError: damaged, or of another place; the message is one sentence.
    """
    index = read_index(folder)
    if not is_of_place(index, origin):
        raise PointMapError(
            f"{folder} is no map of this campus: {_frame_text(index)}, and the campus map has its origin at "
            f"{_origin_text(origin)}."
        )
    for entry in index.tiles:
        read_tile(folder, entry)
    return index


def is_of_place(index: PointMapIndex | OccupancyTilesIndex, origin: Origin) -> bool:
    """Whether both have one frame, so that a place on one is the same place on the other."""
    return is_same_frame(index.origin, origin)


def tile_source(folder: Path, index: PointMapIndex) -> TileSource:
    """Tiles by place. Reading one raises PointMapError if it has been damaged since the map was checked."""
    entries = {(entry.ix, entry.iy): entry for entry in index.tiles}

    def tile(ix: int, iy: int) -> Surfels | None:
        entry = entries.get((ix, iy))
        return None if entry is None else read_tile(folder, entry)

    return tile


def _frame_text(index: PointMapIndex) -> str:
    if index.origin is None:
        return "it was made without GNSS and begins at its first scan"
    return f"it has its origin at {_origin_text(index.origin)}"


def _origin_text(origin: Origin) -> str:
    return f"{origin.latitude_deg:.7f}, {origin.longitude_deg:.7f}"
