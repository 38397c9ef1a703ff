"""`make bench`: the short form of every benchmark; refreshes the table in benchmarks/README.md."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
README = FOLDER / "README.md"
BEGIN, END = "<!-- figures -->", "<!-- end of figures -->"

SHORT_FORMS: tuple[tuple[str, ...], ...] = (
    ("benchmarks.loop", "--seconds", "20", "--virtual-seconds", "40"),
    ("benchmarks.tracking",),
    ("benchmarks.tracking.stop_and_go",),
    ("benchmarks.identify", "--plants", "50"),
    ("benchmarks.monte_carlo", "--runs", "4", "--stacks", "snow_lion"),
    ("benchmarks.planner", "--seeds", "60"),
    ("benchmarks.drive_by_wire", "--injections", "380", "--hours", "0.1"),
    ("benchmarks.mpc", "--steps", "20000"),
    ("benchmarks.decisions", "--vehicles", "12", "--rides", "50"),
    ("benchmarks.decisions", "--vehicles", "1000", "--rides", "4000"),
    ("benchmarks.bookings", "--seconds", "10"),
    ("benchmarks.ingest", "--seconds", "10"),
    ("benchmarks.connections", "--vehicles", "2000", "--seconds", "10"),
    ("benchmarks.connections.slow_readers", "--seconds", "15"),
    ("benchmarks.replies",),
    ("benchmarks.maps",),
    ("benchmarks.sensors", "--scans", "100"),
    ("benchmarks.perception", "--turns", "100"),
    ("benchmarks.tracker", "--seconds", "20"),
    ("benchmarks.localization", "--km", "2", "--runs", "1"),
)


def main() -> None:
    rows = []
    for module, *arguments in SHORT_FORMS:
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "report.json"
            command = [sys.executable, "-m", module, *arguments, "--json", str(out)]
            subprocess.run(command, check=True, cwd=FOLDER.parent)
            report = json.loads(out.read_text())
        rows += _rows(module, arguments, report)
    _refresh(rows, report["machine"], report["commit"])


def _rows(module: str, arguments: list[str], report: dict[str, Any]) -> list[str]:
    command = " ".join(["python -m", module, *arguments])
    return [f"| `{command}` | `{name}` | {_figure(value)} |" for name, value in report["summary"].items()]


def _figure(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _refresh(rows: list[str], machine: dict[str, Any], commit: str) -> None:
    """Replace the text between the two marks."""
    text = README.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    facts = f"{machine['cpu']}, {machine['system']}, Python {machine['python']}; commit {commit}"
    table = "\n".join(["| command | figure | value |", "|---|---|---|", *rows])
    README.write_text(f"{before}{BEGIN}\nMeasured on {facts}.\n\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
