"""What a running campus installs is a part of what tests and linters install, hash by hash."""

import re
from pathlib import Path

REQUIREMENTS = Path(__file__).parents[2] / "requirements"


def locked(name: str) -> dict[str, str]:
    """By first line (package, version, platform), all that is locked of it."""
    blocks = re.split(r"\n(?=\S)", (REQUIREMENTS / name).read_text().strip())
    return {block.splitlines()[0]: block for block in blocks}


def test_what_runs_is_what_is_tested() -> None:
    run, everything = locked("run.txt"), locked("lock.txt")
    assert {line: everything.get(line) for line in run} == run


def test_every_package_is_locked_with_its_hashes() -> None:
    assert all(
        "--hash=sha256:" in block for name in ("run.txt", "lock.txt") for block in locked(name).values()
    )
