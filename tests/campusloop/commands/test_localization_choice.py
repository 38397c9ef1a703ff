"""What an operator may choose for localization, and what is refused before anything drives."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.commands.localizing import Localization, chosen_point_map, chosen_profile
from campusloop.shipped import DEFAULT_MAP, PROFILES
from contract.localization_maps import LocalizationMapError
from contract.point_map.map_files import write_tiles
from contract.roads.load import load_map
from contract.roads.model import Origin
from tests.vehicle_agent.localization.scan_map.places import SQUARE, TILE_M, VOXEL_M, a_map
from vehicle_agent.config import ProfileError, load_profile

GNSS, SCANS = Localization.GNSS, Localization.SCANS


@pytest.fixture
def point_map(tmp_path: Path) -> Path:
    folder = tmp_path / "map"
    write_tiles(folder, a_map(SQUARE), TILE_M, VOXEL_M, load_map(DEFAULT_MAP).origin)
    return folder


def test_scans_take_a_whole_map_of_the_campus_and_gnss_none(point_map: Path) -> None:
    assert chosen_point_map(SCANS, point_map, DEFAULT_MAP, has_scene=True) == point_map.resolve()
    assert chosen_point_map(GNSS, None, DEFAULT_MAP, has_scene=False) is None
    with pytest.raises(LocalizationMapError, match="--localization scans"):
        chosen_point_map(GNSS, point_map, DEFAULT_MAP, has_scene=True)
    with pytest.raises(LocalizationMapError, match="needs --scene"):
        chosen_point_map(SCANS, point_map, DEFAULT_MAP, has_scene=False)


def test_without_a_map_the_command_that_makes_one_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(LocalizationMapError, match="campusloop workshop survey"):
        chosen_point_map(SCANS, None, DEFAULT_MAP, has_scene=True)


def test_shuttles_that_localize_by_scans_are_snow_lions_unless_told_otherwise(tmp_path: Path) -> None:
    path = chosen_profile(SCANS, None)
    assert path is not None
    assert load_profile(path).stack == "snow_lion"
    assert chosen_profile(GNSS, None) is None
    gem_e2 = PROFILES / "gem-e2.toml"
    assert chosen_profile(SCANS, gem_e2) == gem_e2
    blind = tmp_path / "blind.toml"
    blind.write_text(gem_e2.read_text().replace("rate_hz = 10.0", "rate_hz = 0.0"))
    with pytest.raises(ProfileError, match=r"gem-e2 has no \[lidar\]"):
        chosen_profile(SCANS, blind)


def test_a_map_of_another_place_ends_the_demo_with_the_reason(tmp_path: Path) -> None:
    write_tiles(tmp_path / "map", a_map(SQUARE), TILE_M, VOXEL_M, Origin(48.0, 11.0))
    given = ["--headless", "--scene", "--localization", "scans", "--point-map", str(tmp_path / "map")]
    done = CliRunner().invoke(app_of(), ["demo", *given])
    assert done.exit_code == 2
    assert "no map of this campus" in " ".join(done.output.split())


def test_the_nus_stack_takes_the_shipped_occupancy_map_and_refuses_a_map_of_surfaces(point_map: Path) -> None:
    cart = chosen_profile(SCANS, PROFILES / "nus-cart.toml")
    shipped = chosen_point_map(SCANS, None, DEFAULT_MAP, has_scene=True, profile=cart)
    assert shipped == (DEFAULT_MAP.parent / "occupancy-map").resolve()
    with pytest.raises(LocalizationMapError, match="map of surfaces"):
        chosen_point_map(SCANS, point_map, DEFAULT_MAP, has_scene=True, profile=cart)
