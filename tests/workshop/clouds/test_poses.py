"""Files of true poses are found beside recordings, and read in both forms."""

from pathlib import Path

import numpy as np
import pytest

from workshop.clouds.errors import CloudFileError
from workshop.clouds.poses import poses_file, read_poses


def test_both_forms_say_the_same(tmp_path: Path) -> None:
    half = np.sqrt(0.5)
    (tmp_path / "tum.txt").write_text(f"# time x y z q\n10.5 1 2 3 0 0 {half} {half}\n")
    (tmp_path / "kitti.txt").write_text("0 -1 0 1 1 0 0 2 0 0 1 3\n")
    tum, stamps_s = read_poses(tmp_path / "tum.txt")
    kitti, none = read_poses(tmp_path / "kitti.txt")
    assert tum == pytest.approx(kitti, abs=1e-9)
    assert stamps_s is not None
    assert stamps_s.tolist() == [10.5]
    assert none is None


def test_the_poses_of_a_recording_lie_beside_it(tmp_path: Path) -> None:
    scans = tmp_path / "drive"
    scans.mkdir()
    assert poses_file(scans) is None
    (tmp_path / "groundtruth.txt").write_text("")
    assert poses_file(scans) == tmp_path / "groundtruth.txt"
    (tmp_path / "drive.txt").write_text("")
    assert poses_file(scans) == tmp_path / "drive.txt"
    (scans / "poses.txt").write_text("")
    assert poses_file(scans) == scans / "poses.txt"


@pytest.mark.parametrize("text", ["", "1 2 3\n", "1 2 3 4 5 6 7 nan\n", "a b c\n", "1 2 3 4 5 6 7 8\n1 2\n"])
@pytest.mark.filterwarnings("ignore:loadtxt:UserWarning")
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "poses.txt").write_text(text)
    with pytest.raises(CloudFileError):
        read_poses(tmp_path / "poses.txt")
