import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.scenes.drive import VEHICLE_ID, SceneDrive
from campusloop.studies.identification.identification_drive import identification_scene, winding_path
from contract.geometry import arc_lengths, curvatures
from simulator.vehicle.random_plant import random_plant
from vehicle_agent.config import Profile, load_profile

RUNNER = CliRunner()
APP = app_of(("vehicle",))


def test_a_folder_without_segments_is_refused(tmp_path: Path) -> None:
    result = RUNNER.invoke(APP, ["vehicle", "identify", str(tmp_path), "--out", str(tmp_path / "p.toml")])
    assert result.exit_code == 2
    assert "No segments" in result.output


def test_a_profile_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "0000.mcap").write_bytes(b"")
    out = tmp_path / "p.toml"
    out.write_text("mine")
    result = RUNNER.invoke(APP, ["vehicle", "identify", str(tmp_path), "--out", str(out)])
    assert result.exit_code == 2
    assert out.read_text() == "mine"


def test_a_file_that_is_no_run_is_refused(tmp_path: Path) -> None:
    (tmp_path / "0000.mcap").write_bytes(b"not a run")
    result = RUNNER.invoke(APP, ["vehicle", "identify", str(tmp_path), "--out", str(tmp_path / "p.toml")])
    assert result.exit_code == 2
    assert not (tmp_path / "p.toml").exists()


def test_a_drive_is_not_recorded_over_another(tmp_path: Path) -> None:
    (tmp_path / "0000.mcap").write_bytes(b"")
    result = RUNNER.invoke(APP, ["vehicle", "drive", "--out", str(tmp_path)])
    assert result.exit_code == 2


def test_the_winding_road_turns_both_ways_within_the_turning_circle() -> None:
    path = winding_path(5.0)
    curvature = curvatures(path)[2:-2]
    assert curvature.max() > 0.08
    assert curvature.min() < -0.08
    assert abs(curvature).max() < 1.0 / 5.0
    assert arc_lengths(path)[-1] > 900.0


@pytest.mark.long
def test_a_recorded_drive_through_can_and_gate_identifies_an_unknown_vehicle(tmp_path: Path) -> None:
    SceneDrive(identification_scene(Profile(), 1, 2), tmp_path / "runs").run()
    out = tmp_path / "p.toml"
    result = RUNNER.invoke(
        APP,
        [
            "vehicle",
            "identify",
            str(tmp_path / "runs"),
            "--out",
            str(out),
            "--plots",
            str(tmp_path / "plots"),
        ],
    )
    assert result.exit_code == 0, result.output
    plant, profile = random_plant(Profile(), 2, VEHICLE_ID), load_profile(out)
    response = profile.response
    assert response.steer_dead_s == pytest.approx(plant.steer_delay_s, abs=0.02)
    assert response.throttle_dead_s == pytest.approx(plant.throttle_delay_s, abs=0.02)
    assert response.brake_dead_s == pytest.approx(plant.brake_delay_s, abs=0.02)
    assert response.steer_bias_rad == pytest.approx(plant.steer_bias_rad, abs=math.radians(0.1))
    assert profile.body.wheelbase_m == pytest.approx(plant.wheelbase_m, abs=0.02)
    assert not profile.driving.identification_drive
    assert {path.name for path in (tmp_path / "plots").iterdir()} == {"pedals.png", "steering.png"}
