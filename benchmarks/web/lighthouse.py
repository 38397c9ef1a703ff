"""What Lighthouse says of the passenger page, as a phone gets it from the real server.

Lighthouse (Apache-2.0) loads the page in Chromium and computes from its trace what a slow phone on a slow network would
take (its mobile profile: 150 ms round trip, 1.6 Mbit/s, a quarter of the processor's speed). It is a tool of its own in
`web/tools/lighthouse`, with Node 22.19 or newer by its own word; with Node 20 it runs and warns.
"""

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from statistics import median

from tests.e2e.chromium import chromium_path
from tests.e2e.server_process import ROOT, ServerProcess

PROGRAM = ROOT / "web" / "tools" / "lighthouse" / "node_modules" / ".bin" / "lighthouse"
# As Lighthouse names them, and as we do.
CATEGORIES = {
    "performance": "lighthouse_performance",
    "accessibility": "lighthouse_accessibility",
    "best-practices": "lighthouse_best_practices",
    "seo": "lighthouse_seo",
}
# The performance of one load is that of one moment of this machine.
RUNS = 3
_WITHIN_S = 180.0


def require_lighthouse() -> None:
    """Raises RuntimeError, which says what to do."""
    if not PROGRAM.exists():
        raise RuntimeError(
            "Lighthouse is not installed: run `make lighthouse`, or leave it out (--skip-lighthouse)"
        )


def lighthouse_scores(server: ServerProcess, runs: int = RUNS) -> dict[str, float]:
    """From 0 to 100, by our names: the median of several loads. Raises RuntimeError."""
    reports = [_report(server.origin) for _ in range(runs)]
    return {
        ours: median(round(100.0 * report["categories"][name]["score"]) for report in reports)
        for name, ours in CATEGORIES.items()
    }


def _report(address: str) -> dict[str, dict[str, dict[str, float]]]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "report.json"
        command = (
            str(PROGRAM),
            address,
            "--quiet",
            "--output=json",
            f"--output-path={path}",
            "--form-factor=mobile",
            f"--only-categories={','.join(CATEGORIES)}",
            "--chrome-flags=--headless --no-sandbox --disable-gpu",
        )
        environment = {**os.environ, "CHROME_PATH": shutil.which(chromium_path()) or chromium_path()}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=_WITHIN_S)
        if done.returncode != 0:
            raise RuntimeError(f"Lighthouse failed: {done.stderr[-2000:]}")
        report: dict[str, dict[str, dict[str, float]]] = json.loads(path.read_bytes())
        return report
