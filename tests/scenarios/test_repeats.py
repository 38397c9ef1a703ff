"""The whole campus repeats: the same seed gives the same bytes, whatever the process hashes by."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MINUTES_S = 60.0


def begin(folder: Path, seed: int, hash_seed: str) -> "subprocess.Popen[str]":
    folder.mkdir()
    return subprocess.Popen(
        [sys.executable, "-m", "tests.scenarios.campus_minutes", str(folder), str(seed), str(MINUTES_S)],
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        stdout=subprocess.PIPE,
        text=True,
    )


def hashes(process: "subprocess.Popen[str]") -> dict[str, str]:
    printed, _ = process.communicate(timeout=600)
    assert process.returncode == 0
    found: dict[str, str] = json.loads(printed.splitlines()[-1])
    return found


@pytest.mark.long
def test_a_campus_repeats_bit_for_bit_in_another_process_with_another_hash_seed(tmp_path: Path) -> None:
    first, second = begin(tmp_path / "a", 7, "1"), begin(tmp_path / "b", 7, "2")
    assert hashes(first) == hashes(second)
