"""A vehicle drives by a whole map of its own campus, and by no other."""

from pathlib import Path

import pytest

from contract.point_map.map_files import INDEX, PointMapError, write_tiles
from contract.roads.load import encode_map
from contract.roads.model import Origin
from tests.contract.roads.ring_map import ring_map
from tests.vehicle_agent.localization.scan_map.places import SQUARE, TILE_M, VOXEL_M, a_map
from vehicle_agent.localization.scan_map.stored_map import checked_index, tile_source
from vehicle_agent.runtime.processes.agent_files import AgentFolder

RING = ring_map()


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    folder = tmp_path / "map"
    write_tiles(folder, a_map(SQUARE), TILE_M, VOXEL_M, RING.origin)
    return folder


def damage(folder: Path) -> None:
    tile = next((folder / "tiles").iterdir())
    tile.write_bytes(tile.read_bytes()[:-1] + b"x")


def test_a_whole_map_of_this_campus_gives_its_tiles(stored: Path) -> None:
    index = checked_index(stored, RING.origin)
    tile = tile_source(stored, index)
    first = index.tiles[0]
    found = tile(first.ix, first.iy)
    assert found is not None
    assert len(found) == first.points
    assert tile(900, 900) is None


def test_a_damaged_tile_is_refused_by_its_name(stored: Path) -> None:
    damage(stored)
    with pytest.raises(PointMapError, match=r"\.tile is not the tile that the index names"):
        checked_index(stored, RING.origin)


@pytest.mark.parametrize("origin", [Origin(48.0, 11.0), None])
def test_a_map_of_another_place_is_refused(tmp_path: Path, origin: Origin | None) -> None:
    write_tiles(tmp_path / "map", a_map(SQUARE), TILE_M, VOXEL_M, origin)
    with pytest.raises(PointMapError, match="no map of this campus"):
        checked_index(tmp_path / "map", RING.origin)


def test_a_vehicle_keeps_its_map_when_a_damaged_one_is_installed(stored: Path, tmp_path: Path) -> None:
    files = AgentFolder(tmp_path / "vehicle")
    files.root.mkdir()
    (files.root / "map.json").write_bytes(encode_map(RING))
    assert files.checked_point_map() is None
    installed = files.install_point_map(stored)
    assert files.checked_point_map() == installed
    damage(stored)
    with pytest.raises(PointMapError):
        files.install_point_map(stored)
    assert files.checked_point_map() == installed


def test_a_folder_without_a_map_says_so(tmp_path: Path) -> None:
    with pytest.raises(PointMapError, match="holds no point map"):
        checked_index(tmp_path, RING.origin)
    assert not (tmp_path / INDEX).exists()
