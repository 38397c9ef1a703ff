"""Scans of a run log as the page asks for them."""

from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.runlog.matched_scans import AGREES, NEW, THROUGH, matched_scan
from contract.runlog.records import SCAN_TOPIC, RunHeader
from contract.runlog.writer import SegmentWriter
from server.live.recorded_scans import recorded_scans

S = 1_000_000_000
POINTS = np.array([[10.0, 1.0], [11.0, 2.0], [12.0, 3.0], [13.0, 4.0]])


def a_segment(path: Path, *texts: bytes | None) -> Path:
    """One message a second; None: a scan with a point of each kind and two of them on the map."""
    header = RunHeader("s1", "b1", 0, "campus", "v1", "snow_lion", "0.1.0", 0, 1)
    writer = SegmentWriter(path, header, b"", b"", b"")
    for number, text in enumerate(texts, start=1):
        kinds = np.array([AGREES, NEW, AGREES, THROUGH])
        scan = matched_scan(number * S - 100, Pose2(9.0, 1.0, 0.0), 0.51234, POINTS, kinds)
        writer.add(SCAN_TOPIC, number * S, msgspec.json.encode(scan) if text is None else text)
    writer.close()
    return path


def test_the_scans_of_a_time_come_in_order_with_their_points_by_kind(tmp_path: Path) -> None:
    found = recorded_scans([a_segment(tmp_path / "a.mcap", None, None, None)], 2_000, 3_000)
    (scan,) = found
    assert scan.at_ms == 2_000
    assert scan.agreement == 0.512
    assert (scan.agrees, scan.new, scan.through) == ([10.0, 1.0, 12.0, 3.0], [11.0, 2.0], [13.0, 4.0])


def test_a_message_that_is_no_scan_ends_its_segment_and_no_other(tmp_path: Path) -> None:
    first = a_segment(tmp_path / "a.mcap", None, b'{"stamp_ns":"x"}', None)
    second = a_segment(tmp_path / "b.mcap", None)
    assert [scan.at_ms for scan in recorded_scans([first, second], 0, 9_000)] == [1_000, 1_000]


def test_a_run_without_scans_has_none(tmp_path: Path) -> None:
    assert recorded_scans([a_segment(tmp_path / "a.mcap")], 0, 9_000) == []
