"""`campusloop runs` from the outside, on a run that a shuttle has driven in the simulator."""

import csv
import io
import json
import math
from datetime import datetime
from pathlib import Path

import pytest
from mcap.reader import make_reader
from typer.testing import CliRunner, Result

from campusloop.cli import app_of
from campusloop.virtual.solo_drive import VEHICLE_ID, SoloDrive
from contract.roads.load import load_map
from contract.roads.projection import project
from contract.runlog.reader import reports
from contract.runlog.records import TICK_TOPIC
from tests.server.feeds.roads.shipped import CAMPUS_MAP

RUN = CliRunner()
DRIVE_S = 12.0


def invoke(*arguments: str | Path) -> Result:
    return RUN.invoke(app_of(("runs",)), ["runs", *map(str, arguments)])


@pytest.fixture(scope="module")
def segment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shuttle sets off and drives."""
    folder = tmp_path_factory.mktemp("drive")
    drive = SoloDrive(load_map(CAMPUS_MAP), folder, 1)
    drive.set_off()
    for _ in range(round(DRIVE_S * 50)):
        drive.step()
    assert drive.world.truth(VEHICLE_ID).speed_mps > 1.0
    drive.vehicle.shut_down()
    (path,) = folder.rglob("*.mcap")
    return path


@pytest.fixture
def cut(segment: Path, tmp_path: Path) -> Path:
    path = tmp_path / "cut.mcap"
    path.write_bytes(segment.read_bytes()[: segment.stat().st_size * 3 // 4])
    return path


def test_the_list_names_the_run_and_where_it_lies(segment: Path) -> None:
    done = invoke("list", segment.parents[1])
    assert done.exit_code == 0, done.output
    heading, line = done.stdout.splitlines()
    assert heading.split()[0] == "run"
    assert line.startswith(f"{VEHICLE_ID}/")
    assert line.endswith(str(segment.parent))


def test_what_the_list_names_is_shown(segment: Path) -> None:
    listed = json.loads(invoke("list", segment.parents[1], "--json").stdout)
    (run,) = listed["runs"]
    assert run["segments"] == [str(segment)]
    shown = json.loads(invoke("show", run["run"], "--in", segment.parents[1], "--json").stdout)
    assert shown["run"] == run["run"]
    assert 5.0 < shown["distance_m"] < 5.0 * DRIVE_S
    assert shown["events"]["mode_changed"] >= 1
    assert shown["defects"] == []


def test_a_run_is_summed_up_with_the_commands_that_open_it(segment: Path) -> None:
    done = invoke("show", segment)
    assert done.exit_code == 0, done.output
    lines = {line.split()[0]: line[10:] for line in done.stdout.splitlines()}
    assert lines["ended"].startswith("driving at ")
    assert lines["view"] == f"campusloop view {segment.parent}"
    assert lines["replay"] == f"campusloop replay {segment.parent}"


def test_a_segment_that_a_kill_cut_short_is_summed_up_and_said_to_be_cut(cut: Path) -> None:
    done = invoke("show", cut)
    assert done.exit_code == 0, done.output
    assert "ends in the middle of a record" in done.stderr
    assert "use the server's copy" in done.stderr


def test_a_segment_without_its_head_ends_with_2_and_what_to_do(segment: Path, tmp_path: Path) -> None:
    stump = tmp_path / "stump.mcap"
    stump.write_bytes(segment.read_bytes()[:200])
    for command in (["list", stump], ["show", stump], ["export", stump, "--out", tmp_path / "x.csv"]):
        done = invoke(*command)
        assert done.exit_code == 2, done.output
        assert str(stump) in done.stderr
        assert "use the server's copy" in done.stderr


def test_what_is_no_run_ends_with_2_and_what_to_do(segment: Path, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("no run")
    for arguments, remedy in (
        (["list", tmp_path], "no run logs"),
        (["list", tmp_path / "nowhere"], "name a folder with run logs"),
        (["show", tmp_path / "notes.txt"], "is no MCAP file"),
        (["show", "shuttle-9/boot-9", "--in", segment.parents[1]], "campusloop runs list"),
    ):
        done = invoke(*arguments)
        assert done.exit_code == 2, done.output
        assert remedy in done.stderr


def test_the_table_has_every_report_of_the_localized_vehicle_where_it_was(
    segment: Path, tmp_path: Path
) -> None:
    out = tmp_path / "run.csv"
    assert invoke("export", segment, "--out", out).exit_code == 0
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    recorded = {round(log_ns / 1e6): status for log_ns, status in reports(segment)}
    assert 0.8 * len(recorded) < len(rows) <= len(recorded)
    origin = load_map(CAMPUS_MAP).origin
    for row in rows:
        at_ms = round(datetime.fromisoformat(row["utc"]).timestamp() * 1e3)
        # The table's times are cut to milliseconds.
        status = recorded.get(at_ms) or recorded[at_ms + 1]
        place = project(origin, float(row["latitude_deg"]), float(row["longitude_deg"]))
        assert math.dist(place, (status.pose_map.x_m, status.pose_map.y_m)) < 0.02
        assert float(row["speed_mps"]) == pytest.approx(status.speed_mps, abs=1e-3)


def test_the_line_has_a_time_for_each_of_its_places(segment: Path, tmp_path: Path) -> None:
    out, table = tmp_path / "run.geojson", tmp_path / "run.csv"
    assert invoke("export", segment, "--out", out).exit_code == 0
    assert invoke("export", segment, "--out", table).exit_code == 0
    (feature,) = json.loads(out.read_text())["features"]
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert feature["geometry"]["type"] == "LineString"
    assert feature["geometry"]["coordinates"] == [
        [float(row["longitude_deg"]), float(row["latitude_deg"])] for row in rows
    ]
    assert feature["properties"]["coordTimes"] == [row["utc"] for row in rows]


def test_the_file_for_foxglove_has_all_that_is_drawn_and_no_ticks(segment: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    assert invoke("export", segment, "--out", out).exit_code == 0
    with segment.open("rb") as before, out.open("rb") as after:
        recorded = [(c.topic, m.log_time, m.data) for _, c, m in make_reader(before).iter_messages()]
        drawn = [
            (channel.topic, message.log_time, message.data, schema is not None)
            for schema, channel, message in make_reader(after).iter_messages()
        ]
    assert [one[:3] for one in drawn] == [one for one in recorded if one[0] != TICK_TOPIC]
    assert len(drawn) < len(recorded)
    assert all(has_schema for *_, has_schema in drawn)
    assert out.stat().st_size < segment.stat().st_size


def test_the_sound_part_of_a_cut_segment_is_exported(segment: Path, cut: Path, tmp_path: Path) -> None:
    for kind in ("mcap", "csv"):
        out, whole = tmp_path / f"cut.out.{kind}", tmp_path / f"whole.{kind}"
        done = invoke("export", cut, "--out", out)
        assert done.exit_code == 0, done.output
        assert "ends in the middle of a record" in done.stderr
        assert invoke("export", segment, "--out", whole).exit_code == 0
        assert 0 < out.stat().st_size < whole.stat().st_size


def test_no_file_is_overwritten_and_no_other_kind_is_written(segment: Path, tmp_path: Path) -> None:
    there = tmp_path / "run.csv"
    there.write_text("mine")
    assert invoke("export", segment, "--out", there).exit_code == 2
    assert there.read_text() == "mine"
    other = invoke("export", segment, "--out", tmp_path / "run.bag")
    assert other.exit_code == 2
    assert ".geojson" in other.stderr
    nowhere = invoke("export", segment, "--out", tmp_path / "no" / "run.csv")
    assert nowhere.exit_code == 2
    assert "cannot be written" in nowhere.stderr
