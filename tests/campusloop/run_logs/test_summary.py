"""How far a run went, what happened, and how it ended: against numbers that can be worked out by hand."""

from pathlib import Path

import msgspec
import pytest
import zstandard

from campusloop.run_logs.folders import RecordedRun, runs_found
from campusloop.run_logs.summary import ending, run_summary
from contract.runlog.records import EVENT_TOPIC, REPORT_TOPIC
from contract.runlog.writer import SegmentWriter
from contract.wire.codec import encode
from contract.wire.events import DoorsChanged
from contract.wire.messages import Status
from tests.contract.runlog.test_segment import a_header, a_status, write_segment

REPORT_NS = 200_000_000


def run_of(folder: Path, statuses: list[tuple[int, Status]], doors: int = 0) -> RecordedRun:
    path = folder / "0000.mcap"
    writer = SegmentWriter(path, a_header(), b"state", b"profile", zstandard.compress(b"{}"))
    for stamp_ns, status in statuses:
        writer.add(REPORT_TOPIC, stamp_ns, encode(status))
    for number in range(doors):
        body = msgspec.json.encode(DoorsChanged(open=number % 2 == 0, visit_id="v"))
        writer.add(EVENT_TOPIC, statuses[-1][0], body)
    writer.close()
    (run,) = runs_found(folder).runs
    return run


def at_speed(stamp_ns: int, speed_mps: float) -> Status:
    return msgspec.structs.replace(a_status(stamp_ns), speed_mps=speed_mps)


def test_the_distance_is_the_speed_over_time_backwards_too(tmp_path: Path) -> None:
    speeds_mps = [0.0, 1.0, 2.0, 2.0, -1.0]
    reports = [(k * REPORT_NS, at_speed(k * REPORT_NS, speed)) for k, speed in enumerate(speeds_mps)]
    summary = run_summary(run_of(tmp_path, reports, doors=3))
    assert summary.distance_m == pytest.approx(0.2 * (0.5 + 1.5 + 2.0 + 1.5))
    assert summary.events == {"doors_changed": 3}
    assert summary.defects == ()


def test_the_way_in_a_gap_of_the_recording_is_not_made_up(tmp_path: Path) -> None:
    reports = [(stamp_ns, at_speed(stamp_ns, 3.0)) for stamp_ns in (0, REPORT_NS, 60_000_000_000)]
    assert run_summary(run_of(tmp_path, reports)).distance_m == pytest.approx(0.6)


def test_the_ending_says_what_the_vehicle_did_and_why_it_did_not_drive(tmp_path: Path) -> None:
    last = msgspec.structs.replace(
        at_speed(REPORT_NS, 0.0), mode="held", hold_reason="operator_hold", hold_detail="tree", aboard=("r",)
    )
    assert ending(run_summary(run_of(tmp_path / "held", [(REPORT_NS, last)]))) == (
        "standing, held (operator hold: tree), 1 ride aboard"
    )
    moving = run_summary(run_of(tmp_path / "moving", [(REPORT_NS, at_speed(REPORT_NS, 2.5))]))
    assert ending(moving) == "driving at 2.5 m/s, autonomous"


def test_of_a_segment_that_a_kill_cut_short_the_sound_part_counts(tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    write_segment(whole, 3_000)
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    (run,) = runs_found(cut).runs
    summary = run_summary(run)
    assert [error.code for error in summary.defects] == ["truncated"]
    # The first report comes after 0.2 s, and the last up to 0.2 s before the end.
    assert summary.distance_m == pytest.approx(3.0 * run.duration_s, abs=1.2)
