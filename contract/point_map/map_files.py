"""Point maps on disk: an index document and the tiles that it names by content.

DIR/index.json      format, map_version, tile_m, voxel_m, frame, origin, and of each tile: ix, iy, file,
                    bytes, sha256 (of the file), points
DIR/tiles/*.tile    `tiles.py`

`map_version` is the SHA-256 of the tiles' digests in order, so a changed tile is another map. The index is
written last, and moved into place: a folder without one is no map.
"""

import hashlib
import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import msgspec

from contract.localization_maps import LocalizationMapError
from contract.point_map.tiles import FORMAT, Surfels, TileError, decode_tile, encode_tile
from contract.roads.model import Origin

INDEX, TILES = "index.json", "tiles"


class PointMapError(LocalizationMapError):
    """The folder holds no point map, or a changed one; the message is one sentence."""


class TileEntry(msgspec.Struct, frozen=True):
    """One tile of the index: its place in tiles from the origin, its file and what must be in it."""

    ix: int
    iy: int
    file: str
    bytes: int
    sha256: str
    points: int


class PointMapIndex(msgspec.Struct, frozen=True):
    """frame: "map" if GNSS fixes placed it on the origin's tangent plane, "first_scan" otherwise."""

    format: int
    map_version: str
    tile_m: float
    voxel_m: float
    frame: Literal["map", "first_scan"]
    origin: Origin | None
    tiles: tuple[TileEntry, ...]


def write_tiles(
    folder: Path,
    tiles: Mapping[tuple[int, int], Surfels],
    tile_m: float,
    voxel_m: float,
    origin: Origin | None,
) -> PointMapIndex:
    """Writes tiles and then the index into a new folder. Raises OSError; then there is no index."""
    encoded = {
        (ix, iy): (encode_tile(ix, iy, tile_m, surfels), len(surfels)) for (ix, iy), surfels in tiles.items()
    }
    return write_encoded_tiles(folder, encoded, tile_m, voxel_m, origin)


def write_encoded_tiles(
    folder: Path,
    tiles: Mapping[tuple[int, int], tuple[bytes, int]],
    tile_m: float,
    voxel_m: float,
    origin: Origin | None,
) -> PointMapIndex:
    """The same for tiles' bytes and counts of elements: tiles of another map keep their bytes."""
    (folder / TILES).mkdir(parents=True)
    entries = []
    for (ix, iy), (data, points) in sorted(tiles.items()):
        name = f"{TILES}/{ix}_{iy}.tile"
        _write(folder / name, data)
        entries.append(TileEntry(ix, iy, name, len(data), hashlib.sha256(data).hexdigest(), points))
    index = PointMapIndex(
        FORMAT, version_of(entries), tile_m, voxel_m, "first_scan" if origin is None else "map", origin,
        tuple(entries),
    )  # fmt: skip
    document = msgspec.json.format(msgspec.json.encode(index), indent=1)
    _write(folder / f"{INDEX}.new", document + b"\n")
    (folder / f"{INDEX}.new").replace(folder / INDEX)
    return index


def version_of(entries: Sequence[TileEntry]) -> str:
    """The map's version: the SHA-256 of its tiles' places and digests."""
    lines = "".join(f"{entry.ix} {entry.iy} {entry.sha256}\n" for entry in entries)
    return hashlib.sha256(lines.encode()).hexdigest()


def read_index(folder: Path) -> PointMapIndex:
    """The index of a map. Raises PointMapError."""
    path = folder / INDEX
    try:
        data = path.read_bytes()
    except OSError as error:
        raise PointMapError(f"{folder} holds no point map: {error.strerror or error}.") from error
    return decode_index(data, str(path))


def decode_index(data: bytes, name: str) -> PointMapIndex:
    """The index in these bytes; name: of their file, for messages. Raises PointMapError."""
    try:
        version = json.loads(data).get("format")
        if version != FORMAT:
            raise PointMapError(f"{name} has format {version}, not {FORMAT}.")
        index = msgspec.json.decode(data, type=PointMapIndex)
    except (msgspec.MsgspecError, ValueError, AttributeError) as error:
        raise (
            error
            if isinstance(error, PointMapError)
            else PointMapError(f"{name} is no index of a point map: {error}.")
        ) from error
    if not (math.isfinite(index.tile_m) and index.tile_m > 0.0 and index.voxel_m > 0.0):
        raise PointMapError(f"{name} states no usable size of tiles.")
    if index.map_version != version_of(index.tiles):
        raise PointMapError(f"{name} has been changed since it was written.")
    return index


def read_tile(folder: Path, entry: TileEntry) -> Surfels:
    """One tile, checked against the index. Raises PointMapError."""
    return decode_entry(_tile_bytes(folder, entry), entry, str(folder / entry.file))


def read_tile_bytes(folder: Path, entry: TileEntry) -> bytes:
    """The bytes of one tile, those that the index names. Raises PointMapError."""
    data = _tile_bytes(folder, entry)
    _check_bytes(data, entry, str(folder / entry.file))
    return data


def decode_entry(data: bytes, entry: TileEntry, name: str) -> Surfels:
    """The tile in these bytes, checked against the index; name: of their file. Raises PointMapError."""
    _check_bytes(data, entry, name)
    try:
        ix, iy, surfels = decode_tile(data)
    except TileError as error:
        raise PointMapError(f"{name}: {error}") from error
    if (ix, iy) != (entry.ix, entry.iy):
        raise PointMapError(f"{name} is the tile of another place.")
    return surfels


def _tile_bytes(folder: Path, entry: TileEntry) -> bytes:
    if Path(entry.file).is_absolute() or ".." in Path(entry.file).parts:
        raise PointMapError(f"{entry.file} is no file of the map's folder.")
    path = folder / entry.file
    try:
        return path.read_bytes()
    except OSError as error:
        raise PointMapError(f"{path} cannot be read: {error.strerror or error}.") from error


def _check_bytes(data: bytes, entry: TileEntry, name: str) -> None:
    if len(data) != entry.bytes or hashlib.sha256(data).hexdigest() != entry.sha256:
        raise PointMapError(f"{name} is not the tile that the index names.")


def _write(path: Path, data: bytes) -> None:
    """Whole and on the disk, or an OSError."""
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
