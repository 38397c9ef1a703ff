"""Bookings at a steady rate on the real server, by `benchmarks.bookings`."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

RATE_PER_S = 50.0


def booking_p95_ms(seconds: float) -> float:
    """Of the answers, each counted from the moment at which the booking was due."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "bookings.json"
        command = [sys.executable, "-m", "benchmarks.bookings", "--rate", str(RATE_PER_S)]
        subprocess.run([*command, "--seconds", str(seconds), "--json", str(report)], check=True)
        summary = json.loads(report.read_text())["summary"]
    if summary["failed"]:
        raise RuntimeError(f"{summary['failed']} bookings were not answered")
    return float(summary["p95_ms"])
