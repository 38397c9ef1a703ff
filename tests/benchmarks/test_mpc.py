"""The MPC benchmark drives what it says, and every problem of it is solved."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
def test_a_short_course_is_followed_with_every_problem_solved(tmp_path: Path) -> None:
    report = tmp_path / "mpc.json"
    subprocess.run(
        [sys.executable, "-m", "benchmarks.mpc", "--steps", "8000", "--json", report],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    found = json.loads(report.read_text())
    assert found["summary"]["infeasible"] == 0
    assert found["summary"]["steps"] >= 8000
    assert found["summary"]["p99_cpu_ms"] > 0.0
    whole, slow = found["rows"]
    assert whole["not_followed"] == slow["not_followed"] == 0
    assert 0.05 < whole["standing_ratio"] < 0.5
    assert whole["peak_offset_m"] < 0.03
    # A steering of 1 degree a second is what the bound is for.
    assert slow["bound_met"] > 0.3 * slow["steps"]
    assert slow["peak_offset_m"] < 0.15
