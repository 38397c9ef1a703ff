"""`campusloop workshop map --clouds` from the outside: maps, and input that makes none."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from typer.testing import CliRunner

from benchmarks.odometry.simulated import Loop, SimulatedDrive
from campusloop.cli import app_of
from contract.point_map import map_files
from contract.point_map.map_files import read_index, read_tile

RUN = CliRunner()


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """KITTI files of a drive of a few seconds, every second scan."""
    folder = tmp_path_factory.mktemp("drive")
    drive = SimulatedDrive(5, Loop(length_m=24.0, width_m=22.0, radius_m=8.0, speed_mps=4.0))
    lines = []
    for number, (cloud, pose) in enumerate(zip(drive.clouds(), drive.truth(), strict=True)):
        if number == 40:
            break
        points = np.column_stack((cloud.points_sensor, cloud.intensities)).astype("<f4")
        (folder / f"{number:06d}.bin").write_bytes(points.tobytes())
        lines.append(" ".join(f"{value:.6f}" for value in pose[:3].ravel()))
    (folder / "truth.txt").write_text("\n".join(lines) + "\n")
    return folder


def mapped(out: Path, *more: str) -> Result:
    return RUN.invoke(app_of(["workshop"]), ["workshop", "map", "--out", str(out), *more])


def test_scans_become_a_map_with_its_report(scans: Path, tmp_path: Path) -> None:
    out = tmp_path / "map"
    done = mapped(out, "--clouds", str(scans), "--truth", str(scans / "truth.txt"))
    assert done.exit_code == 0, done.output
    index = read_index(out)
    assert sum(len(read_tile(out, tile)) for tile in index.tiles) > 500
    report = json.loads((out / "report.json").read_text())
    assert report["map_version"] == index.map_version
    assert report["residuals"]["ate_m"] < 0.5
    assert len((out / "trajectory.csv").read_text().splitlines()) == 41
    assert (out / "picture.png").stat().st_size > 10_000
    # The drive has no loop yet, and it says so.
    assert "No loop was found" in done.output
    again = mapped(out, "--clouds", str(scans))
    assert again.exit_code == 2
    assert "holds a map already" in again.output


def test_a_damaged_scan_is_left_out_and_said(scans: Path, tmp_path: Path) -> None:
    folder = tmp_path / "cut"
    shutil.copytree(scans, folder)
    cut = folder / "000020.bin"
    cut.write_bytes(cut.read_bytes()[:-7])
    (folder / "000021.bin").write_bytes(np.full((500, 4), np.nan, dtype="<f4").tobytes())
    done = mapped(tmp_path / "map", "--clouds", str(folder))
    assert done.exit_code == 0, done.output
    assert "000020.bin" in done.output
    assert "1 scans have too few points" in done.output


def test_a_full_disk_leaves_nothing_and_has_its_own_exit_code(
    scans: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = map_files._write

    def full(path: Path, data: bytes) -> None:
        written(path, data[: len(data) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(map_files, "_write", full)
    out = tmp_path / "here" / "map"
    done = mapped(out, "--clouds", str(scans))
    assert done.exit_code == 3
    assert "No space left on device" in done.output
    assert "No map was left there" in done.output
    assert list((tmp_path / "here").iterdir()) == []


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ((), "give either --laser or --clouds"),
        (("--clouds", "none"), "does not exist"),
        (("--clouds", "SCANS", "--gnss", "none.csv"), "cannot be read"),
        (("--clouds", "SCANS", "--truth", "none.txt"), "no file of poses"),
    ],
)
def test_input_that_makes_no_map_is_refused(
    more: tuple[str, ...], words: str, scans: Path, tmp_path: Path
) -> None:
    named = [str(scans) if part == "SCANS" else part for part in more]
    done = mapped(tmp_path / "map", *named)
    assert done.exit_code == 2
    assert words in done.output
    assert not (tmp_path / "map").exists()
