"""`campusloop map` from the outside."""

from pathlib import Path

import pytest
from msgspec.structs import replace
from typer.testing import CliRunner

from campusloop.commands.map import app
from contract.roads.load import encode_map, load_map
from contract.roads.model import RestingPlace
from server.feeds.roads.generated import generated_osm
from tests.contract.roads.ring_map import ring_map
from tests.server.feeds.roads.shipped import SNOW_LION_MAP

RUN = CliRunner()


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "made.osm"
    path.write_bytes(generated_osm(1))
    return path


def test_an_import_writes_a_sound_map_and_lists_what_it_did(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "maps" / "map.json"
    done = RUN.invoke(app, ["import", str(source), "--out", str(out), "--campus-id", "made"])
    assert done.exit_code == 0, done.output
    assert "repaired" in done.output
    assert "left out" in done.output
    assert load_map(out).campus_id == "made"
    checked = RUN.invoke(app, ["check", str(out)])
    assert checked.exit_code == 0, checked.output
    assert "is sound" in checked.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bounds", "1,2,3"], "bad_bounds"),
        (["--bounds", "5,2,3,4"], "bad_bounds"),
        (["--names", "/nowhere.csv"], "bad_names"),
        (["--bounds", "50,10,51,11"], "no_roads"),
    ],
)
def test_bad_options_end_with_2_and_write_nothing(
    source: Path, tmp_path: Path, arguments: list[str], words: str
) -> None:
    out = tmp_path / "map.json"
    done = RUN.invoke(app, ["import", str(source), "--out", str(out), *arguments])
    assert done.exit_code == 2, done.output
    assert words in done.output
    assert not out.exists()


def test_a_broken_file_ends_with_2_and_leaves_the_old_map_alone(tmp_path: Path) -> None:
    source, out = tmp_path / "cut.osm", tmp_path / "map.json"
    source.write_bytes(generated_osm(1)[:2000])
    out.write_bytes(b"the old map")
    done = RUN.invoke(app, ["import", str(source), "--out", str(out)])
    assert done.exit_code == 2
    assert "download or export it again" in done.output
    assert out.read_bytes() == b"the old map"


def test_checking_a_defective_map_ends_with_1_and_names_the_defect(tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    bad = replace(ring_map(), resting_places=(RestingPlace("r", "side-3", 24.0),))
    path.write_bytes(encode_map(bad))
    done = RUN.invoke(app, ["check", str(path)])
    assert done.exit_code == 1
    assert "tight_place" in done.output


def test_checking_a_cut_map_ends_with_2(tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    path.write_bytes(encode_map(ring_map())[:500])
    done = RUN.invoke(app, ["check", str(path)])
    assert done.exit_code == 2
    assert "map_broken" in done.output


def test_the_schematic_map_is_written(tmp_path: Path) -> None:
    out = tmp_path / "map.json"
    assert RUN.invoke(app, ["schematic", "--out", str(out)]).exit_code == 0
    assert load_map(out).schematic


@pytest.mark.parametrize("kind", ["geojson", "lanelet2"])
def test_an_exported_map_is_imported_again_under_the_same_version(tmp_path: Path, kind: str) -> None:
    source, out, back = tmp_path / "map.json", tmp_path / "out.file", tmp_path / "back.json"
    source.write_bytes(encode_map(load_map(SNOW_LION_MAP)))
    exported = RUN.invoke(app, ["export", str(source), "--out", str(out), "--format", kind])
    assert exported.exit_code == 0, exported.output
    done = RUN.invoke(app, ["import", str(out), "--out", str(back)])
    assert done.exit_code == 0, done.output
    assert load_map(back).map_version == load_map(source).map_version


def test_an_unknown_format_ends_with_2(tmp_path: Path) -> None:
    done = RUN.invoke(app, ["export", str(SNOW_LION_MAP), "--out", str(tmp_path / "x"), "--format", "shape"])
    assert done.exit_code == 2, done.output
