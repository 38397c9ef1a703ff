"""Tiles keep what they were given, and what is damaged or changed is refused with its reason."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.point_map.map_files import INDEX, PointMapError, read_index, read_tile, write_tiles
from contract.point_map.tiles import Surfels, TileError, decode_tile, encode_tile
from contract.roads.model import Origin

TILE_M = 32.0


def surfels_on(ix: int, iy: int, count: int, seed: int, high_m: float = 20.0) -> Surfels:
    rng = np.random.default_rng(seed)
    means = rng.uniform((0.0, 0.0, -2.0), (TILE_M, TILE_M, high_m), (count, 3))
    means[:, :2] += TILE_M * np.array([ix, iy])
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    normals[::3] = 0.0
    return Surfels(
        means, normals, rng.uniform(0.0, 0.5, count), rng.integers(1, 200, count).astype(np.float64)
    )


@given(st.integers(-900, 900), st.integers(-900, 900), st.integers(0, 60), st.integers(0, 9))
def test_a_tile_keeps_its_elements_to_a_millimetre(ix: int, iy: int, count: int, seed: int) -> None:
    surfels = surfels_on(ix, iy, count, seed)
    data = encode_tile(ix, iy, TILE_M, surfels)
    x, y, found = decode_tile(data)
    assert (x, y, len(found)) == (ix, iy, count)
    assert found.means == pytest.approx(surfels.means, abs=0.00101)
    assert found.normals == pytest.approx(surfels.normals, abs=0.01)
    assert found.std_m == pytest.approx(surfels.std_m, abs=0.00101)
    assert np.array_equal(found.seen, surfels.seen)
    assert encode_tile(ix, iy, TILE_M, surfels) == data


@given(st.integers(0, 400), st.integers(0, 255))
def test_a_damaged_tile_is_refused_or_whole(at: int, value: int) -> None:
    surfels = surfels_on(1, 2, 40, 3)
    data = bytearray(encode_tile(1, 2, TILE_M, surfels))
    data[at % len(data)] = value
    try:
        _, _, found = decode_tile(bytes(data))
    except TileError:
        return
    assert np.isfinite(found.means).all()


def test_a_tile_that_is_cut_off_or_too_high_is_refused() -> None:
    data = encode_tile(0, 0, TILE_M, surfels_on(0, 0, 40, 1))
    for end in (0, 3, len(data) // 2, len(data) - 1):
        with pytest.raises(TileError):
            decode_tile(data[:end])
    with pytest.raises(TileError, match="more than 66 m"):
        encode_tile(0, 0, TILE_M, surfels_on(0, 0, 40, 1, high_m=900.0))


def a_map(folder: Path) -> Path:
    tiles = {(0, 0): surfels_on(0, 0, 30, 1), (-1, 2): surfels_on(-1, 2, 20, 2)}
    write_tiles(folder, tiles, TILE_M, 0.5, Origin(31.0, 121.0))
    return folder


def test_a_map_is_read_as_it_was_written(tmp_path: Path) -> None:
    folder = a_map(tmp_path / "map")
    index = read_index(folder)
    assert [(tile.ix, tile.iy, tile.points) for tile in index.tiles] == [(-1, 2, 20), (0, 0, 30)]
    assert index.frame == "map"
    assert len(read_tile(folder, index.tiles[1])) == 30
    assert read_index(a_map(tmp_path / "again")).map_version == index.map_version


def test_a_changed_tile_or_index_is_refused(tmp_path: Path) -> None:
    folder = a_map(tmp_path / "map")
    index = read_index(folder)
    path = folder / index.tiles[0].file
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(PointMapError, match="not the tile that the index names"):
        read_tile(folder, index.tiles[0])
    document = json.loads((folder / INDEX).read_text())
    document["tiles"][0]["ix"] = 7
    (folder / INDEX).write_text(json.dumps(document))
    with pytest.raises(PointMapError, match="changed since"):
        read_index(folder)
    for text in ("", "[]", '{"format": 9}', '{"format": 1}', "nonsense"):
        (folder / INDEX).write_text(text)
        with pytest.raises(PointMapError):
            read_index(folder)
    with pytest.raises(PointMapError, match="holds no point map"):
        read_index(tmp_path / "none")


def test_a_tile_outside_of_the_folder_is_not_read(tmp_path: Path) -> None:
    folder = a_map(tmp_path / "map")
    entry = read_index(folder).tiles[0]
    import msgspec

    for file in ("../secret", "/etc/passwd"):
        with pytest.raises(PointMapError, match="no file of the map"):
            read_tile(folder, msgspec.structs.replace(entry, file=file))
