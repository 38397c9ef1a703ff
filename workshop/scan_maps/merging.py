"""The proposed map: changed and added tiles are made again, all others keep their bytes."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contract.point_map.map_files import PointMapIndex, read_tile_bytes, write_encoded_tiles
from contract.point_map.tiles import Surfels, encode_tile
from contract.roads.model import Origin
from workshop.cloud_mapping.map_folder import tiles_of
from workshop.scan_maps.comparison import UNSEEN, Changes, TileChange

# A tile of which so little was seen is left as it is, or out.
ADDED_MIN = 60


def write_proposed_tiles(
    folder: Path, old_folder: Path | None, old_index: PointMapIndex | None, new: Surfels, old: Surfels,
    changes: Changes, tiles: Sequence[TileChange], frame: tuple[float, float, Origin],
) -> tuple[PointMapIndex, tuple[tuple[int, int], ...]]:  # fmt: skip
    """(the index, the tiles that are made again). frame: edge of tiles, edge of voxels, origin.

    A tile that is made again has the new elements, and of the old ones those that the scans did not see.
    Raises OSError, PointMapError, TileError.
    """
    tile_m, voxel_m, origin = frame
    encoded: dict[tuple[int, int], tuple[bytes, int]] = {}
    if old_folder is not None and old_index is not None:
        for entry in old_index.tiles:
            encoded[entry.ix, entry.iy] = (read_tile_bytes(old_folder, entry), entry.points)
    new_tiles = tiles_of(new, tile_m)
    kept_tiles = tiles_of(old.selected(changes.old == UNSEEN), tile_m)
    remade = []
    for tile in tiles:
        at = tile.ix, tile.iy
        fresh, kept = new_tiles.get(at), kept_tiles.get(at)
        is_worth_adding = tile.is_added and fresh is not None and len(fresh) >= ADDED_MIN
        if not (tile.is_changed or is_worth_adding):
            continue
        parts = [part for part in (fresh, kept) if part is not None and len(part)]
        remade.append(at)
        if not parts:
            encoded.pop(at, None)
            continue
        whole = _joined(parts)
        encoded[at] = (encode_tile(*at, tile_m, whole), len(whole))
    return write_encoded_tiles(folder, encoded, tile_m, voxel_m, origin), tuple(remade)


def _joined(parts: Sequence[Surfels]) -> Surfels:
    return Surfels(
        np.concatenate([part.means for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.std_m for part in parts]),
        np.concatenate([part.seen for part in parts]),
    )
