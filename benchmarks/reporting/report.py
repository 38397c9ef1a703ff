"""The report of a benchmark: a printed table, and one JSON object with machine, commit and rows."""

import json
import os
import platform
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

Value = float | int | str | bool | None
Row = Mapping[str, Value]

_ROOT = Path(__file__).resolve().parents[2]


def machine() -> dict[str, Value]:
    """The processor and its software, without which figures cannot be compared."""
    return {
        "cpu": _cpu_model(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
    }


def commit() -> str:
    """The commit that was measured; "-dirty" when files differed from it, "unknown" outside a checkout."""
    try:
        described = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=_ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
    except (FileNotFoundError, subprocess.CalledProcessError):
        return "unknown"
    return described.stdout.strip()


def reference_loop_s() -> float:
    """Wall time of 10 million turns of a small pure-Python loop: how fast this machine is right now."""
    begun_s = time.perf_counter()
    total = 0
    for turn in range(10_000_000):
        total += turn & 3
    assert total == 15_000_000
    return time.perf_counter() - begun_s


class RunReport:
    """The report of one run: created when the run begins, written when it ends."""

    def __init__(self) -> None:
        self._reference_loop_before_s = reference_loop_s()

    def machine(self) -> dict[str, Value]:
        """`machine()` with its speed before and after the run; reference_loop_s is the mean of both."""
        before_s, after_s = self._reference_loop_before_s, reference_loop_s()
        return machine() | {
            "reference_loop_s": 0.5 * (before_s + after_s),
            "reference_loop_before_s": before_s,
            "reference_loop_after_s": after_s,
        }

    def write(
        self,
        path: Path | None,
        name: str,
        arguments: Mapping[str, Value | Sequence[Value]],
        rows: Sequence[Row],
        summary: Row,
    ) -> None:
        """Print the rows and the summary; write the whole as one JSON object when a path is given."""
        print_rows(name, rows)
        print_rows(f"{name}: summary", [summary])
        if path is None:
            return
        report = {
            "name": name,
            "machine": self.machine(),
            "commit": commit(),
            "arguments": dict(arguments),
            "rows": [dict(row) for row in rows],
            "summary": dict(summary),
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(report, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def print_rows(title: str, rows: Sequence[Row]) -> None:
    """A table with one column for each key, units in the keys."""
    table = Table(title=title, title_justify="left")
    columns = list(dict.fromkeys(key for row in rows for key in row))
    for column in columns:
        table.add_column(column, justify="right")
    for row in rows:
        table.add_row(*(_cell(row.get(column)) for column in columns))
    Console(width=max(80, 24 * len(columns))).print(table)


def _cell(value: Value) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)


def _cpu_model() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.lower().startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
