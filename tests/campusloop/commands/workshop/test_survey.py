"""`campusloop workshop survey` and `survey-laser` from the outside, on a campus of one round of 70 m."""

import itertools
import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import Result
from typer.testing import CliRunner

from campusloop.cli import app_of
from contract.occupancy.tile_files import INDEX as OCCUPANCY_INDEX
from contract.point_map.map_files import read_index, read_tile
from contract.roads.load import encode_map
from contract.roads.model import (
    Building,
    Lane,
    Origin,
    RestingPlace,
    RoadMap,
    Section,
    Stop,
)

RUN = CliRunner()
RADIUS_M, STRAIGHT_M = 7.0, 14.0


def a_round() -> RoadMap:
    """Two streets and the bends between them, a house inside and four outside."""
    k = np.linspace(-math.pi / 2, math.pi / 2, 24)
    bend = np.column_stack((RADIUS_M * np.cos(k), RADIUS_M + RADIUS_M * np.sin(k)))
    x = np.linspace(0.0, STRAIGHT_M, 15)
    shapes = {
        "south": np.column_stack((x, np.zeros(15))),
        "east": bend + np.array([STRAIGHT_M, 0.0]),
        "north": np.column_stack((x[::-1], np.full(15, 2 * RADIUS_M))),
        "west": np.column_stack((-bend[:, 0], 2 * RADIUS_M - bend[:, 1])),
    }
    names = list(shapes)
    lanes = tuple(
        Lane(
            name, "road" if name in ("south", "north") else "turn",
            tuple((float(a), float(b)) for a, b in shapes[name]), 3.0, 3.0, False, (then,),
        )
        for name, then in itertools.pairwise([*names, names[0]])
    )  # fmt: skip
    lengths = {name: float(np.hypot(*np.diff(shape, axis=0).T).sum()) for name, shape in shapes.items()}
    sections = tuple(Section(f"{name}/0", name, 0.0, length, ()) for name, length in lengths.items())
    houses = tuple(
        Building(((x0, y0), (x0 + 6.0, y0), (x0 + 6.0, y0 + 4.0), (x0, y0 + 4.0)), 5.0)
        for x0, y0 in ((4.0, 5.0), (2.0, -10.0), (12.0, -11.0), (3.0, 20.0), (-18.0, 4.0), (28.0, 6.0))
    )
    stops = (Stop("a", "A", "south", 8.0), Stop("b", "B", "north", 8.0))
    return RoadMap(
        "round",
        "Round",
        Origin(31.3, 121.4),
        lanes,
        sections,
        stops,
        (RestingPlace("rest", "west", 4.0),),
        houses,
    )


def written(folder: Path, road_map: RoadMap) -> str:
    path = folder / "campus.json"
    path.write_bytes(encode_map(road_map))
    return str(path)


def ran(*arguments: str) -> Result:
    return RUN.invoke(app_of(["workshop"]), ["workshop", *arguments])


def test_a_survey_makes_a_point_map_of_the_scene(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "map"
    done = ran("survey", "--map", written(tmp_path, a_round()), "--stops", "a,b", "--out", str(out))
    assert done.exit_code == 0, done.output
    index = read_index(out)
    assert sum(len(read_tile(out, tile)) for tile in index.tiles) > 500
    report = json.loads((out / "report.json").read_text())
    assert report["residuals"]["keyframes"] > 10
    again = ran("survey", "--map", written(tmp_path, a_round()), "--out", str(out))
    assert again.exit_code == 2
    assert "is not empty" in again.output


def test_a_laser_survey_makes_occupancy_tiles(tmp_path: Path) -> None:
    out = tmp_path / "tiles"
    done = ran("survey-laser", "--map", written(tmp_path, a_round()), "--out", str(out), "--km", "0.1")
    assert done.exit_code == 0, done.output
    assert (out / OCCUPANCY_INDEX).exists()
    assert any(out.rglob("*"))
    again = ran("survey-laser", "--map", written(tmp_path, a_round()), "--out", str(out))
    assert again.exit_code == 2
    assert "is not empty" in again.output


@pytest.mark.parametrize("command", ["survey", "survey-laser"])
def test_a_folder_that_cannot_be_written_ends_it_before_the_drive(command: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("a file is no folder")
    done = ran(command, "--map", written(tmp_path, a_round()), "--out", str(tmp_path / "file" / "map"))
    assert done.exit_code == 3
    assert "cannot be written" in done.output
    assert "scans" not in done.output


@pytest.mark.parametrize("command", ["survey", "survey-laser"])
def test_a_map_that_is_none_is_refused(command: str, tmp_path: Path) -> None:
    (tmp_path / "campus.json").write_text("{}")
    done = ran(command, "--map", str(tmp_path / "campus.json"), "--out", str(tmp_path / "map"))
    assert done.exit_code == 2
    assert not (tmp_path / "map").exists()


def test_a_campus_of_which_no_drive_can_be_made_is_refused(tmp_path: Path) -> None:
    whole = a_round()
    for change, command, says in (
        ({"resting_places": ()}, ("survey",), "no resting place"),
        ({"stops": whole.stops[:1]}, ("survey-laser",), "no way from one stop to another"),
        ({}, ("survey", "--stops", "a,nowhere"), "no stop nowhere"),
    ):
        road_map = msgspec.structs.replace(whole, **change)
        done = ran(*command, "--map", written(tmp_path, road_map), "--out", str(tmp_path / "map"))
        assert done.exit_code == 2, done.output
        assert says in " ".join(done.output.split())
        assert not (tmp_path / "map").exists()


def test_a_vehicle_without_a_planar_scanner_makes_no_laser_survey(tmp_path: Path) -> None:
    done = ran(
        "survey-laser", "--map", written(tmp_path, a_round()), "--out", str(tmp_path / "map"),
        "--profile", "vehicle_agent/profiles/gem-e2.toml",
    )  # fmt: skip
    assert done.exit_code == 2
    assert "planar_scanner" in done.output
