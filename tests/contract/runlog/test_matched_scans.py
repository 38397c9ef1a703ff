"""A scan in the run log comes back to the centimetre, whatever it holds."""

import msgspec
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2
from contract.runlog.matched_scans import (
    AGREES,
    NEW,
    POINTS_MAX,
    REACH_M,
    THROUGH,
    MatchedScan,
    matched_scan,
    points_of,
)

COORDINATES = st.floats(-300.0, 300.0)


@given(
    st.lists(st.tuples(COORDINATES, COORDINATES, st.sampled_from([AGREES, NEW, THROUGH])), max_size=30),
    st.floats(-5_000.0, 5_000.0),
)
def test_points_and_kinds_come_back(rows: list[tuple[float, float, int]], x_m: float) -> None:
    pose = Pose2(x_m, 7.0, 0.3)
    table = np.array(rows, dtype=np.float64).reshape(-1, 3)
    points = table[:, :2] + [pose.x_m, pose.y_m]
    scan = matched_scan(5, pose, 0.5, points, table[:, 2].astype(np.int64))
    again = msgspec.json.decode(msgspec.json.encode(scan), type=MatchedScan)
    assert again == scan
    found, kinds = points_of(again)
    assert np.abs(found - points).max(initial=0.0) < 0.0051
    assert kinds.tolist() == table[:, 2].tolist()


def test_a_large_scan_is_thinned_and_what_is_too_far_is_left_out() -> None:
    points = np.zeros((2 * POINTS_MAX + 1, 2))
    points[0] = REACH_M + 1.0, 0.0
    scan = matched_scan(5, Pose2(0.0, 0.0, 0.0), 0.5, points, np.zeros(len(points), np.int64))
    found, kinds = points_of(scan)
    assert len(found) == len(kinds)
    assert 0.6 * POINTS_MAX < len(found) <= POINTS_MAX
    assert np.abs(found).max() == 0.0


def test_bytes_without_a_partner_are_left_out() -> None:
    scan = MatchedScan(5, Pose2(1.0, 2.0, 0.0), 0.5, b"\x0a\x00\x14\x00\x01\x00", bytes([NEW, THROUGH]))
    points, kinds = points_of(scan)
    assert points.tolist() == [[1.1, 2.2]]
    assert kinds.tolist() == [NEW]
