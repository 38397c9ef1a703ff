"""Kilometres in virtual time: what a shift gives, and what is made of several."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.studies.endurance.endurance_run import EnduranceShift, ShiftFigures, run_shift
from campusloop.studies.endurance.ride_quality_report import summary_of, write_files
from simulator.scoring.ride_quality import stretch

MAP = Path(__file__).resolve().parents[4] / "maps" / "snow-lion" / "map.json"
SPEEDS = np.concatenate((np.linspace(0.0, 3.0, 200), np.full(3000, 3.0), np.linspace(3.0, 0.0, 200)))


def figures(**changes: object) -> ShiftFigures:
    found = stretch(SPEEDS)
    assert found is not None
    out = ShiftFigures(EnduranceShift(MAP, "gem", 1, 0), 200.0, [found], [5.0, 7.0, 20.0])
    for name, value in changes.items():
        setattr(out, name, value)
    return out


def test_takeovers_and_contacts_of_all_shifts_are_counted() -> None:
    summary = summary_of([figures(), figures(takeovers=["stopped", "contact"], contacts=1)])
    assert summary is not None
    assert summary.odometer_km == pytest.approx(0.4)
    assert summary.takeover_km == pytest.approx(0.2)
    assert summary.contacts == 1
    assert summary.position_rms_m is None
    assert summary_of([]) is None


def test_position_errors_of_all_shifts_are_one_figure() -> None:
    summary = summary_of(
        [figures(position_errors_m=[0.03] * 50), figures(position_errors_m=[0.0] * 49 + [0.4])]
    )
    assert summary is not None
    assert summary.position_rms_m == pytest.approx(np.sqrt((50 * 0.03**2 + 0.4**2) / 100))
    assert summary.position_p99_m == pytest.approx(0.03, abs=0.005)


def test_files_and_plots_are_written(tmp_path: Path) -> None:
    shifts = [figures()]
    summary = summary_of(shifts)
    assert summary is not None
    write_files(tmp_path, shifts, summary)
    assert json.loads((tmp_path / "table2.json").read_text())["contacts"] == 0
    assert len((tmp_path / "speeds.csv").read_text().splitlines()) == 1 + len(SPEEDS) // 5
    for name in ("fig8b_speeds.png", "fig9_planning.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


def test_bad_options_are_refused() -> None:
    app = app_of(("simulate",))
    nowhere = CliRunner().invoke(app, ["simulate", "--km", "1", "--map", "nowhere.json"])
    assert nowhere.exit_code == 2
    unknown = CliRunner().invoke(app, ["simulate", "--km", "1", "--stack", "ghost"])
    assert unknown.exit_code == 2
    assert "ghost" in unknown.output
    assert CliRunner().invoke(app, ["simulate"]).exit_code == 2


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--km", "1", "--localization", "scans", "--stack", "nus"], "needs --scene"),
        (["--km", "1", "--localization", "scans", "--scene", "--stack", "gem", "--map", str(MAP)], "no map"),
        (["--km", "1", "--localization", "scans", "--scene", "--stack", "nus", "--map", str(MAP)], "no map"),
        (["--km", "1", "--point-map", "somewhere"], "name it with --map"),
        (["--km", "1", "--point-map", "somewhere", "--map", str(MAP)], "is for --localization scans"),
        (["--map", str(MAP), "--localization", "scans"], "agents localize the vehicles"),
    ],
)
def test_what_shuttles_cannot_localize_by_is_refused(options: list[str], says: str) -> None:
    refused = CliRunner().invoke(app_of(("simulate",)), ["simulate", *options])
    assert refused.exit_code == 2
    assert says in refused.output.replace("\n", " ")


@pytest.mark.long
def test_a_shift_drives_and_repeats() -> None:
    shift = EnduranceShift(MAP, "gem", 3, 0, 160.0)
    first, again = run_shift(shift), run_shift(shift)
    assert first.distance_m > 50.0
    assert first.contacts == 0
    assert first.distance_m == again.distance_m
    assert [one.speed_mps.tobytes() for one in first.stretches] == [
        one.speed_mps.tobytes() for one in again.stretches
    ]
