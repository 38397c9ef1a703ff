from collections.abc import Iterator

import pytest
from sqlalchemy import Engine

from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map


@pytest.fixture
def campus(engine: Engine) -> Iterator[CampusUnderTest]:
    """The Snow Lion campus without vehicles, on SQLite and on PostgreSQL."""
    made = CampusUnderTest(shipped_map("snow-lion"), engine=engine)
    yield made
    made.close()


@pytest.fixture
def fleet(campus: CampusUnderTest) -> FakeFleet:
    """Two shuttles at their resting places, in service."""
    return FakeFleet(campus, shipped_map("snow-lion"), 2).start()


@pytest.fixture
def driven_fleet() -> Iterator[FakeFleet]:
    """The same in memory, for tests that drive for long."""
    made = CampusUnderTest(shipped_map("snow-lion"))
    yield FakeFleet(made, shipped_map("snow-lion"), 2).start()
    made.close()
