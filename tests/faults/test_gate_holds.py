"""SIGSTOP on a real tick: the gate brakes at once, and the vehicle stands until somebody resumes it."""

from pathlib import Path

import pytest

from benchmarks.drive_by_wire.processes import process_faults
from vehicle_agent.config import Profile

pytestmark = pytest.mark.faults


def test_a_killed_and_a_stopped_tick_are_braked_for_and_stay(tmp_path: Path) -> None:
    rows = process_faults(2, Profile(), tmp_path)
    assert [row["kind"] for row in rows] == ["SIGKILL tick", "SIGSTOP tick"]
    for row in rows:
        assert row["right"], row
        assert isinstance(row["latency_ms"], float)
        assert row["latency_ms"] <= 100.0
    assert len(list(tmp_path.glob("process-*.csv"))) == 2
