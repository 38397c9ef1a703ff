"""A scan comes back from its file as it was; another file is refused."""

from pathlib import Path

import numpy as np
import pytest

from tests.workshop.detector.scans import a_scan
from workshop.detector.labeled_scans import ScanFileError, read_scan, write_scan


def test_a_scan_comes_back_within_2_mm(tmp_path: Path) -> None:
    scan = a_scan(1)
    write_scan(tmp_path / "scan.npz", scan)
    back = read_scan(tmp_path / "scan.npz")
    assert np.abs(back.points[:, :3] - scan.points[:, :3]).max() <= 0.0011
    assert np.abs(back.points[:, 3] - scan.points[:, 3]).max() < 1.0
    assert (back.is_older == scan.is_older).all()
    assert (back.boxes == scan.boxes).all()
    assert (back.kinds == scan.kinds).all()
    assert back.older_s == scan.older_s


def test_a_file_that_holds_no_scan_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", points=np.zeros(3))
    with pytest.raises(ScanFileError, match="other"):
        read_scan(tmp_path / "other.npz")
    (tmp_path / "cut.npz").write_bytes(b"PK\x03\x04")
    with pytest.raises(ScanFileError, match="cut"):
        read_scan(tmp_path / "cut.npz")
