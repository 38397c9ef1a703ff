from collections.abc import Callable, Iterator
from typing import TypeVar

import pytest
from sqlalchemy import Engine

from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.shipped_maps import shipped_map

T = TypeVar("T")


class Record:
    """The stored record of one campus, on SQLite and on PostgreSQL."""

    def __init__(self, campus: CampusUnderTest) -> None:
        self.campus = campus

    def do(self, work: Callable[[UnitOfWork], T]) -> T:
        return self.campus.do(work)

    def found(self, work: Callable[[UnitOfWork], T]) -> T:
        """What a reader finds, and a writer, who remembers the fleet, finds as well."""
        read = self.campus.read(work)
        assert self.campus.do(work) == read
        return read


@pytest.fixture
def record(engine: Engine) -> Iterator[Record]:
    campus = CampusUnderTest(shipped_map("snow-lion"), engine=engine)
    yield Record(campus)
    campus.close()
