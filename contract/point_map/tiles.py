"""One tile of a point map: surface elements on a square of the map, and their bytes.

A tile's bytes are a header and columns, all little-endian, compressed by zstd as one frame:

  header   4s "CLPT", u16 format, u16 0, i32 ix, i32 iy, u32 n, f32 base_z_m, f32 tile_m, f32 unit_m
  means    n x i16 x 3   from (ix * tile_m + tile_m / 2, iy * tile_m + tile_m / 2, base_z_m), in unit_m
  normals  n x i8 x 3    in 1/127; 0, 0, 0 where the element is no surface
  spread   n x u8        standard deviation across the surface, or of the points, in 2 mm, at most 0.51 m
  seen     n x u8        keyframes that saw it, at most 255
"""

import math
import struct

import msgspec
import numpy as np
import zstandard

from contract.geometry import Array

FORMAT = 1
_MAGIC = b"CLPT"
_HEADER = struct.Struct("<4sHHiiIfff")
_UNIT_M = 0.002
_SPREAD_M = 0.002
_BYTES_EACH = 11
# Of 64 m with an element each 10 cm; more is no tile.
_ELEMENTS_MAX = 5_000_000


class TileError(ValueError):
    """The bytes are no tile; the message is one sentence."""


class Surfels(msgspec.Struct, frozen=True):
    """Elements of surfaces, map frame.

    means    (n, 3) m
    normals  (n, 3) unit vectors; 0, 0, 0 where the points are on no surface
    std_m    (n,) of the points across the surface, or from the mean
    seen     (n,) keyframes that saw it
    """

    means: Array
    normals: Array
    std_m: Array
    seen: Array

    def __len__(self) -> int:
        return len(self.means)

    def selected(self, chosen: np.ndarray) -> "Surfels":
        return Surfels(self.means[chosen], self.normals[chosen], self.std_m[chosen], self.seen[chosen])


def no_surfels() -> Surfels:
    return Surfels(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))


def encode_tile(ix: int, iy: int, tile_m: float, surfels: Surfels) -> bytes:
    """The bytes of the elements on tile (ix, iy), whose edge is tile_m; equal elements give equal bytes."""
    base_z_m = float(np.float32(np.round(np.median(surfels.means[:, 2])))) if len(surfels) else 0.0
    corner = np.array([(ix + 0.5) * tile_m, (iy + 0.5) * tile_m, base_z_m])
    steps = np.rint((surfels.means - corner) / _UNIT_M)
    if len(surfels) and np.abs(steps).max() > 32_767:
        raise TileError(f"tile {ix}, {iy} has points more than {32.767 * 2.0:.0f} m from its middle.")
    columns = (
        steps.astype("<i2").tobytes(),
        np.rint(127.0 * surfels.normals).astype("i1").tobytes(),
        np.minimum(255.0, np.rint(surfels.std_m / _SPREAD_M)).astype("u1").tobytes(),
        np.minimum(255.0, surfels.seen).astype("u1").tobytes(),
    )
    header = _HEADER.pack(_MAGIC, FORMAT, 0, ix, iy, len(surfels), base_z_m, tile_m, _UNIT_M)
    return zstandard.ZstdCompressor(level=9).compress(header + b"".join(columns))


def decode_tile(data: bytes) -> tuple[int, int, Surfels]:
    """(ix, iy, elements). Raises TileError for bytes that are no whole tile of this format."""
    limit = _HEADER.size + _BYTES_EACH * _ELEMENTS_MAX
    try:
        plain = zstandard.ZstdDecompressor().decompress(data, max_output_size=limit)
    except zstandard.ZstdError as error:
        raise TileError(f"the tile is damaged: {error}.") from error
    if len(plain) < _HEADER.size:
        raise TileError("the tile is cut off.")
    magic, version, _, ix, iy, n, base_z_m, tile_m, unit_m = _HEADER.unpack_from(plain)
    if magic != _MAGIC or version != FORMAT:
        raise TileError("the file is no tile of this version of Campusloop.")
    if len(plain) != _HEADER.size + _BYTES_EACH * n or not math.isfinite(base_z_m + tile_m + unit_m):
        raise TileError("the tile does not have as many points as it says.")
    at = _HEADER.size
    corner = np.array([(ix + 0.5) * tile_m, (iy + 0.5) * tile_m, base_z_m])
    means = corner + unit_m * np.frombuffer(plain, "<i2", 3 * n, at).reshape(n, 3).astype(np.float64)
    normals = np.frombuffer(plain, "i1", 3 * n, at + 6 * n).reshape(n, 3).astype(np.float64)
    length = np.linalg.norm(normals, axis=1)
    normals /= np.where(length > 0.0, length, 1.0)[:, None]
    std_m = _SPREAD_M * np.frombuffer(plain, "u1", n, at + 9 * n).astype(np.float64)
    seen = np.frombuffer(plain, "u1", n, at + 10 * n).astype(np.float64)
    return ix, iy, Surfels(means, normals, std_m, seen)
