"""Scans of a street become a proposal: a wall that has moved is named by its tile, and no other tile is."""

import math
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
import pytest

from contract.point_map.map_files import read_index, read_tile, write_tiles
from contract.roads.model import Origin
from contract.scan_parcels.proposals import COMPARISON, PICTURE, Comparison
from tests.workshop.scan_maps.street import Wall, walls, write_drive
from workshop.cloud_mapping.mapping import NoProgress
from workshop.scan_maps.drives import NoMapOfScans
from workshop.scan_maps.proposal import ProposalParams, propose

Places = set[tuple[int, int]]


@pytest.fixture(scope="module")
def in_force(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The map of the street as it was, without anything to compare it with."""
    folder = tmp_path_factory.mktemp("street")
    parcels = write_drive(folder / "parcels", walls(), seed=1)
    found = propose(parcels, None, folder / "map", folder / "work", ProposalParams(), NoProgress())
    assert found.in_force_version == ""
    assert found.changed_ratio is None
    assert all(tile.is_added and tile.is_remade for tile in found.tiles)
    return folder / "map"


def proposed(tmp_path: Path, in_force: Path, scene: Sequence[Wall], **drive: object) -> Comparison:
    parcels = write_drive(tmp_path / "parcels", scene, seed=2, offset_y_m=-1.0, **drive)  # type: ignore[arg-type]
    return propose(parcels, in_force, tmp_path / "map", tmp_path / "work", ProposalParams(), NoProgress())


def changed(found: Comparison) -> Places:
    return {(tile.ix, tile.iy) for tile in found.tiles if tile.is_changed}


def digests(folder: Path) -> dict[tuple[int, int], str]:
    return {(entry.ix, entry.iy): entry.sha256 for entry in read_index(folder).tiles}


def points(folder: Path) -> np.ndarray:
    index = read_index(folder)
    return np.concatenate([read_tile(folder, entry).means for entry in index.tiles])


def test_a_street_that_has_not_changed_is_proposed_as_it_is(tmp_path: Path, in_force: Path) -> None:
    found = proposed(tmp_path, in_force, walls())
    assert changed(found) == set()
    assert found.map_version == found.in_force_version == read_index(in_force).map_version
    assert found.changed_ratio is not None
    assert found.changed_ratio < 0.01
    assert found.residual_p95_m is not None
    assert found.residual_p95_m < 0.05
    assert math.hypot(*found.shift_m[:2]) < 0.05


@pytest.mark.parametrize("moved_m", [1.5, -1.5])
def test_a_wall_that_has_moved_is_named_by_its_tile_and_the_others_keep_their_bytes(
    tmp_path: Path, in_force: Path, moved_m: float
) -> None:
    found = proposed(tmp_path, in_force, walls(moved_m))
    assert changed(found) == {(1, 0)}
    (tile,) = (tile for tile in found.tiles if tile.is_changed)
    assert tile.moved > 100
    before, after = digests(in_force), digests(tmp_path / "map")
    assert {at for at in before if before[at] != after.get(at)} == {(1, 0)}
    # The wall is where it is now, and no longer where it was.
    x, y, z = points(tmp_path / "map").T
    middle = (x > 41.0) & (x < 49.0) & (z > 0.6)
    assert (middle & (np.abs(y - 8.0 - moved_m) < 0.3)).sum() > 60
    assert (middle & (np.abs(y - 8.0) < 0.3)).sum() < 5
    said = msgspec.json.decode((tmp_path / "map" / COMPARISON).read_bytes(), type=Comparison)
    assert said == found
    assert (tmp_path / "map" / PICTURE).read_bytes().startswith(b"\x89PNG")


def test_a_wall_that_is_gone_is_off_the_proposed_map(tmp_path: Path, in_force: Path) -> None:
    found = proposed(tmp_path, in_force, walls(moved_m=12.0))
    assert changed(found) == {(1, 0)}
    (tile,) = (tile for tile in found.tiles if tile.is_changed)
    assert tile.gone > 60
    x, y, z = points(tmp_path / "map").T
    assert ((x > 41.0) & (x < 49.0) & (z > 0.6) & (np.abs(y - 8.0) < 0.3)).sum() < 5


def test_cars_that_drove_by_are_neither_on_the_map_nor_a_change(tmp_path: Path, in_force: Path) -> None:
    found = proposed(tmp_path, in_force, walls(), cars=[62.0 - 0.8 * number for number in range(128)])
    assert changed(found) == set()
    x, y, z = points(tmp_path / "map").T
    assert ((np.abs(y - 3.0) < 0.4) & (z > 0.4) & (x > 5.0) & (x < 55.0)).sum() == 0


def test_drives_of_two_vehicles_make_one_map(tmp_path: Path, in_force: Path) -> None:
    folder = tmp_path / "parcels"
    parcels = write_drive(folder, walls(1.5), seed=3, name="drive-a", offset_y_m=-1.0)
    parcels += write_drive(folder, walls(1.5), seed=4, name="drive-b", offset_y_m=1.5)
    found = propose(parcels, in_force, tmp_path / "map", tmp_path / "work", ProposalParams(), NoProgress())
    assert found.drives == 2
    assert changed(found) == {(1, 0)}
    assert found.residual_p95_m is not None
    assert found.residual_p95_m < 0.05


def test_heights_come_from_the_map_in_force(tmp_path: Path, in_force: Path) -> None:
    index = read_index(in_force)
    raised = {}
    for entry in index.tiles:
        tile = read_tile(in_force, entry)
        # A hill that the fixes do not tell of.
        means = tile.means + np.column_stack((0.0 * tile.means[:, :2], 20.0 + 0.01 * tile.means[:, 0]))
        raised[entry.ix, entry.iy] = msgspec.structs.replace(tile, means=means)
    write_tiles(tmp_path / "hill", raised, index.tile_m, index.voxel_m, index.origin)
    found = proposed(tmp_path, tmp_path / "hill", walls())
    assert changed(found) == set()
    assert found.residual_p95_m is not None
    assert found.residual_p95_m < 0.15


def test_scans_too_far_apart_are_not_made_a_map_of(tmp_path: Path, in_force: Path) -> None:
    parcels = write_drive(tmp_path / "parcels", walls(), seed=2, step_m=6.0)
    with pytest.raises(NoMapOfScans, match="drive-0 was left out"):
        propose(parcels, in_force, tmp_path / "map", tmp_path / "work", ProposalParams(), NoProgress())


def test_a_damaged_parcel_is_left_out_and_named(tmp_path: Path, in_force: Path) -> None:
    parcels = write_drive(tmp_path / "parcels", walls(), seed=2)
    parcels[1].write_bytes(parcels[1].read_bytes()[:-4000])
    found = propose(parcels, in_force, tmp_path / "map", tmp_path / "work", ProposalParams(), NoProgress())
    assert found.scans == 64
    assert any(parcels[1].name in note for note in found.notes)


def test_scans_that_make_no_map_say_why_and_leave_nothing(tmp_path: Path, in_force: Path) -> None:
    def refused(parcels: list[Path]) -> str:
        with pytest.raises(NoMapOfScans) as found:
            propose(parcels, in_force, tmp_path / "map", tmp_path / "work", ProposalParams(), NoProgress())
        assert not (tmp_path / "map").exists()
        return str(found.value)

    assert "no parcel" in refused([])
    blind = write_drive(tmp_path / "blind", walls(), name="drive-9", step_m=4.0, fixes=False)
    assert "no usable fix" in refused(blind)
    other = write_drive(tmp_path / "other", walls(), name="drive-8", step_m=2.0, origin=Origin(31.4, 121.4))
    assert "another map frame" in refused(other)
    assert "different origins" in refused([*blind, *other])
