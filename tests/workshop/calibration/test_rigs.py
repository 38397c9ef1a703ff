"""Rigs on disk: scans of each lidar, given poses, and poses that were found."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.calibration.corner import simulated_rig
from campusloop.cli import app_of
from contract.transforms import apart, transform_of
from workshop.calibration.calibrate import Calibration
from workshop.calibration.errors import CalibrationError
from workshop.calibration.rigs import extrinsics_toml, load_rig, read_extrinsics
from workshop.clouds.errors import CloudFileError


def write_pcd(path: Path, points: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    header = f"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS {len(points)}\nDATA binary\n"
    path.write_bytes(header.encode() + points.astype("<f4").tobytes())


OPENCALIB_POSES = """device_id: 0
(Roll,Pitch,Yaw,tx,ty,tz): 0 0 0 0 0 0
device_id: 1
(Roll,Pitch,Yaw,tx,ty,tz): 0 10 90 1.5 -0.5 0.25
"""
OPENCALIB_FILES = "device_id: 0\npath: data/0001/top.pcd\ndevice_id: 1\npath: data/0001/left.pcd\n"
LEFT = transform_of(0.0, np.radians(10.0), np.radians(90.0), np.array([1.5, -0.5, 0.25]))


def a_calibration() -> Calibration:
    return Calibration(
        ("top", "left"), np.array([np.eye(4), LEFT]), np.full((2, 6), 0.001), np.ones(2), (3, 3), (),
        np.zeros((0, 4)), np.ones(2), (False, False),
    )  # fmt: skip


def test_opencalibs_poses_are_guesses_and_its_unmoved_lidar_the_reference(tmp_path: Path) -> None:
    for name, count in (("left", 900), ("top", 600)):
        write_pcd(tmp_path / f"{name}.pcd", np.full((count, 3), 2.0))
    (tmp_path / "initial_extrinsic.txt").write_text(OPENCALIB_POSES)
    (tmp_path / "lidar_cloud_path.txt").write_text(OPENCALIB_FILES)
    rig = load_rig(tmp_path)
    assert rig.names == ("top", "left")
    assert rig.guesses[1] is not None
    assert sum(apart(rig.guesses[1], LEFT)) < 1e-12
    turned = load_rig(tmp_path, reference="left")
    assert turned.names == ("left", "top")
    assert turned.guesses[1] is not None
    assert turned.guesses[1] @ LEFT == pytest.approx(np.eye(4), abs=1e-12)


def test_folders_of_scans_are_stacked_and_the_fullest_lidar_is_the_reference(tmp_path: Path) -> None:
    for name, scans in (("a", 2), ("b", 3)):
        for number in range(scans):
            write_pcd(tmp_path / name / f"{number}.pcd", np.full((10, 3), number + 1.0))
    rig = load_rig(tmp_path)
    assert [(name, len(cloud)) for name, cloud in zip(rig.names, rig.clouds, strict=True)] == [
        ("b", 30),
        ("a", 20),
    ]
    assert rig.guesses == (None, None)
    assert len(load_rig(tmp_path, scans_max=1).clouds[0]) == 10


def test_poses_that_were_found_can_be_given_again(tmp_path: Path) -> None:
    (tmp_path / "extrinsics.toml").write_text(extrinsics_toml(a_calibration()))
    given = read_extrinsics(tmp_path)
    assert list(given) == ["top", "left"]
    metres, angle_rad = apart(given["left"], LEFT)
    assert metres < 1e-4
    assert angle_rad < 1e-5


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[lidars.left]\nx_m = 1.0\n",
        "lidars = 3",
        '[lidars.left]\nx_m = "far"\n',
        "[lidars.left\n",
        "\xff",
    ],
)
def test_poses_that_cannot_be_read_are_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "extrinsics.toml").write_text(text, encoding="latin-1")
    with pytest.raises(CalibrationError) as refused:
        read_extrinsics(tmp_path)
    assert refused.value.code == "bad_extrinsics"


def test_a_folder_without_two_lidars_is_refused(tmp_path: Path) -> None:
    write_pcd(tmp_path / "alone.pcd", np.ones((5, 3)))
    with pytest.raises(CalibrationError, match="1 lidars: alone"):
        load_rig(tmp_path)
    with pytest.raises(CloudFileError, match="no folder and no bag"):
        load_rig(tmp_path / "none")
    write_pcd(tmp_path / "other.pcd", np.ones((5, 3)))
    with pytest.raises(CalibrationError, match="no lidar third; there are: alone, other"):
        load_rig(tmp_path, reference="third")


def test_the_command_writes_poses_and_plots_and_never_overwrites(tmp_path: Path) -> None:
    vehicle = simulated_rig("corner", np.random.default_rng(1004))
    for name, cloud in zip(("front", "rear"), vehicle.clouds, strict=True):
        write_pcd(tmp_path / "scans" / f"{name}.pcd", cloud)
    app, out = app_of(["workshop"]), tmp_path / "found.toml"
    arguments = ["workshop", "calibrate", str(tmp_path / "scans"), "--reference", "front", "--out", str(out)]
    ran = CliRunner().invoke(app, [*arguments, "--plots", str(tmp_path / "plots")])
    assert ran.exit_code == 0, ran.output
    (tmp_path / "read").mkdir()
    (tmp_path / "read" / "extrinsics.toml").write_bytes(out.read_bytes())
    assert apart(read_extrinsics(tmp_path / "read")["rear"], vehicle.truth[1])[0] < 0.01
    assert sorted(path.name for path in (tmp_path / "plots").iterdir()) == ["residuals.png", "scans.png"]
    again = CliRunner().invoke(app, arguments)
    assert again.exit_code == 2
    assert "exists" in again.output
    refused = CliRunner().invoke(
        app, ["workshop", "calibrate", str(tmp_path / "plots"), "--out", str(tmp_path / "b.toml")]
    )
    assert refused.exit_code == 2
    assert "too_few_lidars" in refused.output
    assert not (tmp_path / "b.toml").exists()
