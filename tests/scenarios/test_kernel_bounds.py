"""No kernel leaves its arrays: compiled once more with checks, whole drives of every stack go through."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.scenarios.checked_cells import PROFILES

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
def test_kernels_with_checked_bounds_drive_every_stack_among_people(tmp_path: Path) -> None:
    checked = subprocess.run(
        [sys.executable, "-m", "tests.scenarios.checked_cells", "--every", "2000"],
        cwd=ROOT,
        # Kernels without checks lie in the usual cache.
        env={**os.environ, "NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert checked.returncode == 0, checked.stderr[-2000:]
    driven = [line.split()[0] for line in checked.stdout.splitlines()]
    assert sorted(set(driven)) == sorted(path.stem for path in PROFILES.glob("*.toml"))
    assert any(tmp_path.rglob("*.nbi")), "no kernel was compiled with checks"
