"""Recorded packets beside what their maker's driver (Nebula) decoded from them, point by point."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from workshop.clouds.recordings import find_recordings

SAMPLES = (
    Path(os.environ.get("CAMPUSLOOP_SHARED", Path(__file__).resolve().parents[4] / "shared"))
    / "data"
    / "lidar"
)
REASON = "no recorded packets here; set CAMPUSLOOP_SHARED to the folder that has data/lidar"


@pytest.fixture(autouse=True)
def samples() -> None:
    if not SAMPLES.exists():
        pytest.skip(REASON)
    pytest.importorskip("rosbags", reason="needs the extra `workshop`")


def truth_of(name: str) -> bytes:
    raw = (SAMPLES / name / "scan.pcd").read_bytes()
    return raw[raw.index(b"DATA binary\n") + 12 :]


def test_xt16_points_are_those_of_the_makers_driver() -> None:
    truth = np.frombuffer(truth_of("xt16"), dtype="<f4").reshape(-1, 3)
    scans = list(find_recordings(SAMPLES / "xt16" / "packets.db3")[0].scans())
    apart = [cKDTree(cloud.points_sensor).query(truth)[0] for cloud in scans if len(cloud) == len(truth)]
    assert min(distances.max() for distances in apart) < 1e-4


def test_vlp16_returns_are_those_of_the_driver_and_azimuths_differ_by_its_rounding() -> None:
    """The driver rounds azimuths to 0.01 degrees, and in dual-return mode does not interpolate them in the
    last sequences of a packet: there they differ by up to 0.35 degrees."""
    fields = np.dtype(
        [
            ("xyz", "<f4", 3),
            ("intensity", "u1"),
            ("kind", "u1"),
            ("ring", "<u2"),
            ("rest", "V12"),
            ("t", "<u4"),
        ]
    )
    truth = np.frombuffer(truth_of("vlp16"), dtype=fields)
    scans = list(find_recordings(SAMPLES / "vlp16" / "packets.db3")[0].scans())
    points = truth["xyz"].astype(np.float64)
    ranges = np.linalg.norm(points, axis=1)
    azimuths = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    best = 0.0
    for cloud in scans:
        ours = cloud.points_sensor.astype(np.float64)
        ours_azimuths = np.degrees(np.arctan2(ours[:, 1], ours[:, 0]))
        # Rings and ranges must be equal; among the equal ones the nearest azimuth counts.
        tree = cKDTree(
            np.column_stack((1e3 * cloud.rings, 1e3 * np.linalg.norm(ours, axis=1), ours_azimuths))
        )
        apart, which = tree.query(np.column_stack((1e3 * truth["ring"], 1e3 * ranges, azimuths)))
        best = max(best, float(np.mean(apart < 0.02)))
        if np.mean(apart < 0.4) > 0.98:
            assert np.mean(apart < 0.02) > 0.82
            assert np.mean(cloud.intensities[which] == truth["intensity"]) > 0.99
            return
    pytest.fail(f"no scan is like the driver's; best {best:.2f}")
