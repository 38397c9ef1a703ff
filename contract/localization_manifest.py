"""The manifest of a localization map: the index of its folder, of either kind, checked for being sent around.

A manifest is the `index.json` of `point_map/map_files.py` or of `occupancy/tile_files.py`, byte for byte. Its
`map_version` is the hash of what the tiles are, so that a version never changes.
"""

import json
import re
from collections.abc import Callable
from typing import Literal

import msgspec

from contract.localization_maps import LocalizationMapError
from contract.occupancy import tile_files as occupancy
from contract.point_map import map_files as points
from contract.roads.model import Origin

LocalizationMapKind = Literal["points", "occupancy"]

# The shipped campus's roads are less than 2,000 tiles of 32 m, of about 30 KB.
TILES_MAX = 20_000
TILE_BYTES_MAX = 16 << 20
MANIFEST_BYTES_MAX = 8 << 20
MAP_BYTES_MAX = 8 << 30

_SHA256 = re.compile(r"[0-9a-f]{64}")
# Below the map's folder, and a name that every disk takes.
_FILE = re.compile(r"tiles/[A-Za-z0-9_-][A-Za-z0-9_.-]{0,99}")


class TileFile(msgspec.Struct, frozen=True):
    """A tile by its content; file: its path below the map's folder."""

    file: str
    bytes: int
    sha256: str


class LocalizationManifest(msgspec.Struct, frozen=True):
    """What any manifest says.

    origin  of the map frame in which the tiles lie
    """

    kind: LocalizationMapKind
    map_version: str
    origin: Origin
    tiles: tuple[TileFile, ...]

    @property
    def size_bytes(self) -> int:
        """Of all tiles together."""
        return sum(tile.bytes for tile in self.tiles)


def decode_manifest(data: bytes) -> LocalizationManifest:
    """The manifest in these bytes, which may come from anywhere. Raises LocalizationMapError."""
    kind, index = _index(data)
    if index.origin is None:
        raise LocalizationMapError(
            "the map was made without GNSS and begins at its first scan: it has no place on a campus"
        )
    if not index.tiles:
        raise LocalizationMapError("the map has no tiles")
    if len(index.tiles) > TILES_MAX:
        raise LocalizationMapError(f"the map has {len(index.tiles)} tiles, {TILES_MAX} at most")
    tiles = tuple(TileFile(entry.file, entry.bytes, entry.sha256) for entry in index.tiles)
    for tile in tiles:
        if not _FILE.fullmatch(tile.file) or not _SHA256.fullmatch(tile.sha256):
            raise LocalizationMapError(f"{tile.file[:100]!r} is no name of a tile with its SHA-256")
        if not 0 < tile.bytes <= TILE_BYTES_MAX:
            raise LocalizationMapError(f"{tile.file} has {tile.bytes} bytes, 1 to {TILE_BYTES_MAX} are taken")
    if len({tile.file for tile in tiles}) < len(tiles):
        raise LocalizationMapError("two tiles of the map have one file")
    if len({(entry.ix, entry.iy) for entry in index.tiles}) < len(tiles):
        raise LocalizationMapError("two tiles of the map have one place")
    manifest = LocalizationManifest(kind, index.map_version, index.origin, tiles)
    if manifest.size_bytes > MAP_BYTES_MAX:
        raise LocalizationMapError(f"the map has {manifest.size_bytes} bytes, {MAP_BYTES_MAX} at most")
    return manifest


def tile_check(data: bytes) -> Callable[[str, bytes], None]:
    """Of a manifest's bytes: takes a tile's SHA-256 and bytes, and raises LocalizationMapError for bytes that
    are not that tile. It decodes the tile, so that no vehicle gets one that it cannot read.
    """
    _kind, index = _index(data)

    def check(sha256: str, tile: bytes) -> None:
        named = 0
        # Equal occupancy tiles may lie at several places; a tile of points knows its own.
        if isinstance(index, points.PointMapIndex):
            for entry in index.tiles:
                if entry.sha256 == sha256:
                    points.decode_entry(tile, entry, entry.file)
                    named += 1
        else:
            for square in index.tiles:
                if square.sha256 == sha256:
                    occupancy.decode_entry(tile, index, square, square.file)
                    named += 1
        if not named:
            raise LocalizationMapError(f"the map has no tile {sha256}")

    return check


def _index(
    data: bytes,
) -> tuple[LocalizationMapKind, points.PointMapIndex | occupancy.OccupancyTilesIndex]:
    if len(data) > MANIFEST_BYTES_MAX:
        raise LocalizationMapError(f"the manifest has more than {MANIFEST_BYTES_MAX} bytes")
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise LocalizationMapError(f"the manifest is no JSON: {error}") from error
    if not isinstance(document, dict):
        raise LocalizationMapError("the manifest is no index of a map's folder")
    if "voxel_m" in document:
        return "points", points.decode_index(data, "the manifest")
    return "occupancy", occupancy.decode_index(data, "the manifest")
