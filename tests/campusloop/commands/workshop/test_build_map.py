"""`campusloop workshop` from the outside."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from contract.occupancy.map_files import read_map
from tests.workshop.simulated_drive import drive, write_carmen

RUN = CliRunner()


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "drive.clf"
    write_carmen(drive(rounds=0.1).log, path)
    return path


def test_a_log_becomes_a_map_with_its_residuals(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = RUN.invoke(app_of(["workshop"]), ["workshop", "map", "--laser", str(log), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "pass_median_m" in done.output
    assert read_map(out / "map.yaml").cells.size > 0
    again = RUN.invoke(app_of(["workshop"]), ["workshop", "map", "--laser", str(log), "--out", str(out)])
    assert again.exit_code == 2
    assert "holds a map already" in again.output


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("nothing\n")
    done = RUN.invoke(
        app_of(["workshop"]), ["workshop", "map", "--laser", str(path), "--out", str(tmp_path / "o")]
    )
    assert done.exit_code == 2
    assert "no CARMEN laser log" in done.output
    assert not (tmp_path / "o").exists()
