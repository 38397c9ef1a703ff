"""Occupancy maps of a whole site on disk: an index document and square tiles that it names by content.

DIR/index.json         format, map_version, tile_m, cell_m, origin; of each tile: ix, iy, file, bytes, sha256
DIR/tiles/IX_IY.cells  the tile's cells, rows from the least y on, compressed by zstd as one frame

Tile (ix, iy) begins at (ix * tile_m, iy * tile_m) of the campus's map frame. `map_version` is the SHA-256 of
the tiles' digests and of the origin. The index is written last: a folder without one is no map.
"""

import hashlib
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path

import msgspec
import numpy as np
import zstandard

from contract.localization_maps import LocalizationMapError
from contract.occupancy.occupancy_map import FORMAT, FREE, OCCUPIED, UNKNOWN, Cells
from contract.roads.model import Origin

INDEX, TILES = "index.json", "tiles"
# Two maps of one campus have the same origin to far less than this (1 cm).
_ORIGIN_DEG = 1e-7
_SIDE_MAX = 4096

TilePlace = tuple[int, int]


class OccupancyTilesError(LocalizationMapError):
    """The folder holds no occupancy tiles, changed ones, or those of another place; one sentence."""


class OccupancyTileEntry(msgspec.Struct, frozen=True):
    """One tile of the index: its place in tiles from the origin, its file and what must be in it."""

    ix: int
    iy: int
    file: str
    bytes: int
    sha256: str


class OccupancyTilesIndex(msgspec.Struct, frozen=True):
    """origin: of the campus's map frame, in which the tiles lie."""

    format: int
    map_version: str
    tile_m: float
    cell_m: float
    origin: Origin
    tiles: tuple[OccupancyTileEntry, ...]

    @property
    def side(self) -> int:
        """Cells along a tile's edge."""
        return round(self.tile_m / self.cell_m)


def write_tiles(
    folder: Path, tiles: Mapping[TilePlace, Cells], tile_m: float, cell_m: float, origin: Origin
) -> OccupancyTilesIndex:
    """Writes tiles and then the index into a new folder. Raises OSError; then there is no index."""
    (folder / TILES).mkdir(parents=True)
    entries = []
    for (ix, iy), cells in sorted(tiles.items()):
        data = zstandard.ZstdCompressor(level=9).compress(np.ascontiguousarray(cells).tobytes())
        name = f"{TILES}/{ix}_{iy}.cells"
        _write(folder / name, data)
        entries.append(OccupancyTileEntry(ix, iy, name, len(data), hashlib.sha256(data).hexdigest()))
    version = _version_of(tuple(entries), tile_m, cell_m, origin)
    index = OccupancyTilesIndex(FORMAT, version, tile_m, cell_m, origin, tuple(entries))
    _write(folder / f"{INDEX}.new", msgspec.json.format(msgspec.json.encode(index), indent=1) + b"\n")
    (folder / f"{INDEX}.new").replace(folder / INDEX)
    return index


def read_index(folder: Path, origin: Origin | None = None) -> OccupancyTilesIndex:
    """The index of a map; with an origin, only one of that campus. Raises OccupancyTilesError."""
    path = folder / INDEX
    try:
        data = path.read_bytes()
    except OSError as error:
        raise OccupancyTilesError(f"{folder} holds no occupancy map: {error.strerror or error}.") from error
    index = decode_index(data, str(path))
    if origin is not None and not _is_same(index.origin, origin):
        raise OccupancyTilesError(
            f"{folder} is the map of another place: its origin is {index.origin.latitude_deg:.6f}, "
            f"{index.origin.longitude_deg:.6f}, and the campus's is {origin.latitude_deg:.6f}, "
            f"{origin.longitude_deg:.6f}."
        )
    return index


def decode_index(data: bytes, name: str) -> OccupancyTilesIndex:
    """The index in these bytes; name: of their file, for messages. Raises OccupancyTilesError."""
    try:
        if "voxel_m" in json.loads(data):
            raise OccupancyTilesError(
                f"{name} is a map of surfaces for lidars; a planar scanner needs an occupancy map."
            )
        index = msgspec.json.decode(data, type=OccupancyTilesIndex)
    except (msgspec.MsgspecError, json.JSONDecodeError, UnicodeDecodeError, TypeError) as error:
        raise OccupancyTilesError(f"{name} is no index of occupancy tiles: {error}.") from error
    if index.format != FORMAT:
        raise OccupancyTilesError(f"{name} has format {index.format}, not {FORMAT}.")
    sizes_fit = math.isfinite(index.tile_m) and 0.0 < index.cell_m <= index.tile_m
    if not (sizes_fit and index.side <= _SIDE_MAX and abs(index.side * index.cell_m - index.tile_m) < 1e-6):
        raise OccupancyTilesError(f"{name} states no usable size of tiles and cells.")
    if index.map_version != _version_of(index.tiles, index.tile_m, index.cell_m, index.origin):
        raise OccupancyTilesError(f"{name} has been changed since it was written.")
    return index


def read_tile(folder: Path, index: OccupancyTilesIndex, entry: OccupancyTileEntry) -> Cells:
    """(side, side) cells of one tile, checked against the index. Raises OccupancyTilesError."""
    if Path(entry.file).is_absolute() or ".." in Path(entry.file).parts:
        raise OccupancyTilesError(f"{entry.file} is no file of the map's folder.")
    path = folder / entry.file
    try:
        data = path.read_bytes()
    except OSError as error:
        raise OccupancyTilesError(f"{path} cannot be read: {error.strerror or error}.") from error
    return decode_entry(data, index, entry, str(path))


def decode_entry(data: bytes, index: OccupancyTilesIndex, entry: OccupancyTileEntry, name: str) -> Cells:
    """The cells in these bytes, checked against the index; name: their file. Raises OccupancyTilesError."""
    if len(data) != entry.bytes or hashlib.sha256(data).hexdigest() != entry.sha256:
        raise OccupancyTilesError(f"{name} is not the tile that the index names.")
    count = index.side * index.side
    try:
        plain = zstandard.ZstdDecompressor().decompress(data, max_output_size=count)
    except zstandard.ZstdError as error:
        raise OccupancyTilesError(f"{name} is damaged: {error}.") from error
    cells = np.frombuffer(plain, dtype=np.uint8)
    if len(cells) != count or not np.isin(cells, (FREE, OCCUPIED, UNKNOWN)).all():
        raise OccupancyTilesError(f"{name} is no tile of {count} cells.")
    return cells.reshape(index.side, index.side)


def _version_of(entries: tuple[OccupancyTileEntry, ...], tile_m: float, cell_m: float, origin: Origin) -> str:
    head = f"{tile_m!r} {cell_m!r} {origin.latitude_deg!r} {origin.longitude_deg!r}\n"
    lines = "".join(f"{entry.ix} {entry.iy} {entry.sha256}\n" for entry in entries)
    return hashlib.sha256((head + lines).encode()).hexdigest()


def _is_same(one: Origin, other: Origin) -> bool:
    return (
        abs(one.latitude_deg - other.latitude_deg) < _ORIGIN_DEG
        and abs(one.longitude_deg - other.longitude_deg) < _ORIGIN_DEG
    )


def _write(path: Path, data: bytes) -> None:
    """Whole and on the disk, or an OSError."""
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
