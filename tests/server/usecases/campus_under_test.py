"""A campus with its server's record and no server: use cases run inline, time moves by hand."""

import asyncio
from collections.abc import Callable, Coroutine
from datetime import UTC, datetime, timedelta
from functools import cache
from typing import Any, TypeVar

from sqlalchemy import Engine

from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from server.adapters import SeededIds
from server.bus.in_process import InProcessBus
from server.domain.rides.rides import Ride
from server.domain.rides.ticket_keys import RideSecrets, TicketKeys
from server.domain.rules import FleetRules
from server.store.roads.map_library import MapLibrary
from server.store.transactions import InlineTransactions
from server.store.unit_of_work import Context
from server.usecases.fleet import campus
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from server.usecases.record.identity import CreatedSession
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.lock_order import watch_lock_order

T = TypeVar("T")
TICKET_KEYS = TicketKeys([bytes(range(32))])
MORNING = datetime(2026, 11, 23, 0, 0, tzinfo=UTC)


class HandClock:
    def __init__(self, now: datetime = MORNING) -> None:
        self.time = now

    def now(self) -> datetime:
        return self.time

    def advance(self, seconds: float) -> None:
        self.time += timedelta(seconds=seconds)


class PlainHasher:
    """Passwords as they are, so that tests need no argon2."""

    def hash(self, password: str) -> str:
        return f"plain:{password}"

    def verify(self, password_hash: str, password: str) -> bool:
        return password_hash == f"plain:{password}"


class NotingBus(InProcessBus):
    """Also notes the topics, for whoever looks now and then."""

    def __init__(self) -> None:
        super().__init__()
        self.said: set[str] = set()

    def wants(self, topic: str) -> bool:
        return True

    async def publish(self, topic: str, payload: bytes) -> None:
        self.said.add(topic)
        await super().publish(topic, payload)

    def heard(self, topic: str) -> bool:
        """Something was said on the topic since the last time."""
        fresh = topic in self.said
        self.said.discard(topic)
        return fresh


@cache
def map_library(rules: FleetRules) -> MapLibrary:
    """One for all campuses with these rules, as for all campuses of a server: map versions never change."""
    return MapLibrary(rules)


class CampusUnderTest:
    """`do` runs a use case in its own transaction. engine: of a database with all tables."""

    def __init__(
        self,
        road_map: RoadMap,
        rules: FleetRules | None = None,
        engine: Engine | None = None,
        seed: int = 1,
        now: datetime = MORNING,
    ) -> None:
        self.road_map = road_map
        self.clock = HandClock(now)
        self.rules = rules or FleetRules()
        self.ids = SeededIds(seed)
        self.bus = NotingBus()
        self.engine = engine or fresh_database()
        watch_lock_order(self.engine)
        self.context = Context(
            road_map.campus_id,
            self.clock,
            self.ids,
            self.rules,
            PlainHasher(),
            map_library(self.rules),
            TICKET_KEYS,
        )
        self._loop = asyncio.new_event_loop()
        self.transactions = InlineTransactions(self.engine, self.context, self.bus)
        self.do(lambda uow: campus.load_map(uow, encode_map(road_map), "test", activate=True))

    def do(self, work: Callable[[UnitOfWork], T]) -> T:
        return self._loop.run_until_complete(self.transactions.run(work))

    def read(self, work: Callable[[UnitOfWork], T]) -> T:
        return self._loop.run_until_complete(self.transactions.read(work))

    def wait_for(self, coroutine: Coroutine[Any, Any, T]) -> T:
        return self._loop.run_until_complete(coroutine)

    def enrol(self, vehicle_id: str, seats: int = 6, wheelchair_places: int = 0, name: str = "") -> str:
        """Enter the vehicle as an operator does. Returns the code with which it enrols its key."""
        return self.do(
            lambda uow: identity.create_enrolment_code(
                uow, vehicle_id, name or vehicle_id, "test", seats=seats, wheelchair_places=wheelchair_places
            )
        )

    def sign_in(self, name: str, password: str) -> CreatedSession:
        """As an operator does. Raises WrongCredentials."""
        check = self.read(lambda uow: identity.password_check(uow, name))
        operator = check.passed(password)
        return self.do(lambda uow: identity.open_operator_session(uow, operator))

    def secrets_of(self, ride: Ride) -> RideSecrets:
        return self.context.tickets.ride_secrets(ride.ticket_key_id, ride.ride_id)

    def release(self) -> None:
        """Let go of the database, so that others can use it."""
        self._loop.run_until_complete(self.transactions.close())
        self._loop.close()

    def close(self) -> None:
        self.release()
        self.engine.dispose()
