"""The watch on the order of locks, under which every test of use cases runs, notices what breaks it."""

from collections.abc import Callable, Iterator
from datetime import UTC, datetime

import pytest
from sqlalchemy import Engine, text

from server.store import tables
from server.store.counters import Counters
from server.store.engine import open_engine
from server.store.fleet.vehicles import SqlVehicleRepository
from server.store.writing.campus_lock import take_campus_lock
from tests.server.usecases.lock_order import LockOrderBroken, watch_lock_order


@pytest.fixture
def watched(new_postgresql: Callable[[], str]) -> Iterator[Engine]:
    engine = open_engine(new_postgresql())
    watch_lock_order(engine)
    yield engine
    engine.dispose()


def test_a_write_before_the_lock_of_the_campus_is_noticed(watched: Engine) -> None:
    with watched.connect() as connection, connection.begin(), pytest.raises(LockOrderBroken):
        connection.execute(tables.counters.insert(), {"campus_id": "c", "name": "fence", "value": 1})


def test_a_row_locked_by_reading_is_noticed(watched: Engine) -> None:
    with watched.connect() as connection, connection.begin(), pytest.raises(LockOrderBroken):
        connection.execute(text("SELECT * FROM vehicles FOR UPDATE"))


def test_the_lock_of_an_earlier_transaction_does_not_count(watched: Engine) -> None:
    with watched.connect() as connection:
        with connection.begin():
            take_campus_lock(connection, "c", 0.5)
        with connection.begin(), pytest.raises(LockOrderBroken):
            connection.execute(tables.counters.delete())


def test_a_repository_writes_only_with_the_lock_of_its_campus_in_hand(engine: Engine) -> None:
    with engine.connect() as connection, connection.begin():
        with pytest.raises(AssertionError, match="only reads"):
            SqlVehicleRepository(connection, "c", None).heard("shuttle-1", datetime.now(UTC))
        lock = take_campus_lock(connection, "c", 0.5)
        assert Counters(connection, "c", lock).next("fence") == 1
        with pytest.raises(AssertionError, match="under the lock of c"):
            Counters(connection, "other", lock).next("fence")
        lock.is_held = False
        with pytest.raises(AssertionError, match="after the transaction"):
            Counters(connection, "c", lock).next("fence")
