from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.scenarios.campus_days import CampusDay


@pytest.fixture
def day(tmp_path: Path) -> Iterator[CampusDay]:
    """One shuttle on the shipped campus, started."""
    day = CampusDay(tmp_path)
    yield day
    day.close()
