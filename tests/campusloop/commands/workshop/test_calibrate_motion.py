"""`campusloop workshop calibrate --inertial` from the outside: a drive, and what is none."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from typer.testing import CliRunner

from benchmarks.calibration.motion import MotionDrive
from campusloop.cli import app_of
from contract.transforms import transform_of
from workshop.motion_calibration.integration import rotation_vectors

RUN = CliRunner()
HEADER = "stamp_s,rate_x_radps,rate_y_radps,rate_z_radps,force_x_mps2,force_y_mps2,force_z_mps2\n"


@pytest.fixture(scope="module")
def drive() -> MotionDrive:
    return MotionDrive(7, "bends", 40.0)


@pytest.fixture(scope="module")
def folder(drive: MotionDrive, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """PCD files with times of points, named by their stamps in ns; and the unit's samples as CSV."""
    folder = tmp_path_factory.mktemp("drive")
    (folder / "scans").mkdir()
    for cloud in drive.clouds():
        some = cloud.selected(np.arange(0, len(cloud), 3))
        row = np.zeros(len(some), dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("t", "<u4")])
        row["x"], row["y"], row["z"] = some.points_sensor.T
        row["t"] = some.offsets_ns
        header = (
            "VERSION 0.7\nFIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
            f"WIDTH {len(some)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(some)}\nDATA binary\n"
        )
        name = f"{1_700_000_000_000_000_000 + cloud.stamp_ns}.pcd"
        (folder / "scans" / name).write_bytes(header.encode() + row.tobytes())
    unit = drive.inertial()
    with (folder / "unit.csv").open("w") as file:
        file.write(HEADER)
        for stamp_s, rates, forces in zip(unit.stamps_s, unit.rates_radps, unit.forces_mps2, strict=True):
            stamp_ns = 1_700_000_000_000_000_000 + unit.start_ns + round(stamp_s * 1e9)
            values = ",".join(f"{value:.6f}" for value in (*rates, *forces))
            file.write(f"{stamp_ns // 10**9}.{stamp_ns % 10**9:09d},{values}\n")
    return folder


def calibrated(*arguments: str) -> Result:
    return RUN.invoke(app_of(["workshop"]), ["workshop", "calibrate", *arguments])


def test_a_drive_gives_a_file_with_the_pose_and_plots(
    drive: MotionDrive, folder: Path, tmp_path: Path
) -> None:
    out, plots = tmp_path / "inertial.toml", tmp_path / "plots"
    lever = [f"{value:.3f}" for value in drive.T_lidar_unit[:3, 3]]
    done = calibrated(
        str(folder / "scans"), "--inertial", str(folder / "unit.csv"), "--lever", *lever,
        "--out", str(out), "--plots", str(plots),
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    found = tomllib.loads(out.read_text())["inertial"]
    angles = np.radians([found[f"{name}_deg"] for name in ("roll", "pitch", "yaw")])
    pose = transform_of(*angles, np.array([found[f"{name}_m"] for name in "xyz"]))
    off = rotation_vectors((pose[:3, :3] @ drive.T_lidar_unit[:3, :3].T)[None])[0]
    assert np.degrees(np.linalg.norm(off)) < 1.0
    assert found["clock_offset_s"] == pytest.approx(drive.offset_s, abs=0.005)
    assert "clock offset" in done.output
    assert all((plots / name).stat().st_size > 5_000 for name in ("rates.png", "motion_residuals.png"))
    again = calibrated(str(folder / "scans"), "--inertial", str(folder / "unit.csv"), "--out", str(out))
    assert again.exit_code == 2
    assert "exists" in again.output


def test_input_that_is_no_drive_is_refused(folder: Path, tmp_path: Path) -> None:
    scans, out = str(folder / "scans"), ("--out", str(tmp_path / "inertial.toml"))
    columns, letters = tmp_path / "columns.csv", tmp_path / "letters.csv"
    columns.write_text("stamp_s,rate_x_radps\n1.0,2.0\n")
    letters.write_text(HEADER + "1.0,2,3,4,5,6,seven\n")
    for inertial, says in (
        (str(columns), "has no column rate_y_radps"),
        (str(letters), "line 2: a value is no number"),
        ("/imu/data", "does not exist"),
    ):
        refused = calibrated(scans, "--inertial", inertial, *out)
        assert refused.exit_code == 2
        assert says in refused.output
    refused = calibrated(str(tmp_path), "--inertial", str(folder / "unit.csv"), *out)
    assert refused.exit_code == 2
    assert "no bag, and no folder of numbered files" in refused.output
    assert not (tmp_path / "inertial.toml").exists()
