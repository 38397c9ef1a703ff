"""A map in tiles comes back as it was, and what is damaged, changed or of another place is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN, Cells
from contract.occupancy.tile_files import (
    INDEX,
    OccupancyTilesError,
    OccupancyTilesIndex,
    read_index,
    read_tile,
    write_tiles,
)
from contract.roads.model import Origin

ORIGIN = Origin(31.3, 121.4)
SIDE = 16


def cells_of(seed: int) -> Cells:
    return np.random.default_rng(seed).choice(np.array([FREE, OCCUPIED, UNKNOWN], np.uint8), (SIDE, SIDE))


def a_map(folder: Path) -> OccupancyTilesIndex:
    return write_tiles(folder, {(0, 0): cells_of(1), (-3, 7): cells_of(2)}, 8.0, 0.5, ORIGIN)


@settings(max_examples=20, deadline=None)
@given(
    st.dictionaries(st.tuples(st.integers(-99, 99), st.integers(-99, 99)), st.integers(0, 2**31), max_size=4)
)
def test_tiles_come_back_as_they_were(
    tmp_path_factory: pytest.TempPathFactory, seeds: dict[tuple[int, int], int]
) -> None:
    folder = tmp_path_factory.mktemp("maps") / "map"
    written = write_tiles(folder, {place: cells_of(seed) for place, seed in seeds.items()}, 8.0, 0.5, ORIGIN)
    index = read_index(folder, ORIGIN)
    assert index == written
    assert {(entry.ix, entry.iy) for entry in index.tiles} == set(seeds)
    for entry in index.tiles:
        assert np.array_equal(read_tile(folder, index, entry), cells_of(seeds[entry.ix, entry.iy]))


def test_another_cell_is_another_map(tmp_path: Path) -> None:
    changed = cells_of(1)
    changed[3, 3] = FREE if changed[3, 3] != FREE else OCCUPIED
    first = write_tiles(tmp_path / "a", {(0, 0): cells_of(1)}, 8.0, 0.5, ORIGIN)
    assert (
        write_tiles(tmp_path / "b", {(0, 0): cells_of(1)}, 8.0, 0.5, ORIGIN).map_version == first.map_version
    )
    assert write_tiles(tmp_path / "c", {(0, 0): changed}, 8.0, 0.5, ORIGIN).map_version != first.map_version


def test_map_of_another_place_is_refused_with_both_places(tmp_path: Path) -> None:
    a_map(tmp_path / "map")
    with pytest.raises(OccupancyTilesError, match=r"another place.*31\.300000.*31\.310000"):
        read_index(tmp_path / "map", Origin(31.31, 121.4))


def test_a_flipped_bit_in_a_tile_is_found(tmp_path: Path) -> None:
    index = a_map(tmp_path / "map")
    path = tmp_path / "map" / index.tiles[0].file
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(data)
    with pytest.raises(OccupancyTilesError, match="not the tile"):
        read_tile(tmp_path / "map", index, index.tiles[0])


def test_a_changed_index_is_refused(tmp_path: Path) -> None:
    a_map(tmp_path / "map")
    path = tmp_path / "map" / INDEX
    document = json.loads(path.read_text())
    document["cell_m"], document["tile_m"] = 0.25, 4.0
    path.write_text(json.dumps(document))
    with pytest.raises(OccupancyTilesError, match="changed since"):
        read_index(tmp_path / "map")


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "x"}', "\udcff"])
def test_what_is_no_index_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / INDEX).write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(OccupancyTilesError):
        read_index(tmp_path)


def test_a_map_of_surfaces_is_refused_by_its_name(tmp_path: Path) -> None:
    (tmp_path / INDEX).write_text('{"format": 1, "voxel_m": 0.5}')
    with pytest.raises(OccupancyTilesError, match="map of surfaces"):
        read_index(tmp_path)


def test_a_folder_without_an_index_is_no_map(tmp_path: Path) -> None:
    with pytest.raises(OccupancyTilesError, match="holds no occupancy map"):
        read_index(tmp_path)
