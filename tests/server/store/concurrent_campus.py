"""A campus whose shuttles, dispatcher and passengers are threads, on several servers and one database."""

import asyncio
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import cycle
from typing import TypeVar

from sqlalchemy import Engine

from server.adapters import RandomIds
from server.domain.rides.rides import BookRide, Ride
from server.store.engine import open_engine
from server.store.transactions import GroupCommit
from server.store.unit_of_work import Context
from server.usecases.fleet import charging, closures
from server.usecases.orders import sections
from server.usecases.planning import plans, promises
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.rides import lost_vehicles, rides
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.lock_order import watch_lock_order
from tests.server.usecases.shipped_maps import shipped_map

T = TypeVar("T")
DISPATCH: tuple[Callable[[UnitOfWork], object], ...] = (
    closures.update_closures,
    lost_vehicles.rescue_riders,
    plans.assign_waiting,
    sections.extend_grants,
    promises.check_promises,
    closures.keep_reachable,
    charging.manage_charging,
    plans.refresh_expected,
)


class ConcurrentCampus(CampusUnderTest):
    """`do` runs on one of the servers in turn, and may be called by any thread."""

    def __init__(self, url: str, servers: int) -> None:
        self._servers: list[Transactions] = []
        super().__init__(shipped_map("snow-lion"), engine=open_engine(url))
        super().release()
        self._serving = asyncio.new_event_loop()
        threading.Thread(target=self._serving.run_forever, daemon=True).start()
        self._servers = [
            GroupCommit(watched(open_engine(url)), self._context_of_server(), self.bus)
            for _ in range(servers)
        ]
        self._turns = cycle(self._servers)

    def do(self, work: Callable[[UnitOfWork], T]) -> T:
        if not self._servers:
            return super().do(work)
        return asyncio.run_coroutine_threadsafe(next(self._turns).run(work), self._serving).result(60.0)

    def read(self, work: Callable[[UnitOfWork], T]) -> T:
        return asyncio.run_coroutine_threadsafe(self._servers[0].read(work), self._serving).result(60.0)

    def close(self) -> None:
        for server in self._servers:
            asyncio.run_coroutine_threadsafe(server.close(), self._serving).result(60.0)
        self._serving.call_soon_threadsafe(self._serving.stop)
        self.engine.dispose()

    def _context_of_server(self) -> Context:
        return replace(self.context, ids=RandomIds())


def watched(engine: Engine) -> Engine:
    watch_lock_order(engine)
    return engine


def run_concurrently(campus: ConcurrentCampus, shuttles: int, rounds: int) -> list[Ride]:
    """Shuttles, dispatcher and passengers do their work so many times, all at once; the answered bookings.

    Raises the first error of any of them.
    """
    fleet = FakeFleet(campus, campus.road_map, shuttles).start()
    stops = [stop.stop_id for stop in campus.road_map.stops]
    booked: list[Ride] = []

    def drive(number: int) -> None:
        for _ in range(rounds):
            fleet.shuttles[number].step()
            fleet.shuttles[number].report()

    def dispatch() -> None:
        for round_ in range(rounds):
            campus.clock.advance(1.0)
            campus.do(DISPATCH[round_ % len(DISPATCH)])

    def book(number: int) -> None:
        for round_ in range(rounds // 10):
            from_stop, to_stop = stops[(round_ + number) % len(stops)], stops[(round_ + 3) % len(stops)]
            if from_stop != to_stop:
                request = BookRide(from_stop, to_stop, party=1)
                booked.append(campus.do(lambda uow, request=request: rides.book(uow, request)))  # type: ignore[misc]

    work: Sequence[Callable[[], None]] = (
        *(lambda number=number: drive(number) for number in range(shuttles)),  # type: ignore[misc]
        dispatch,
        *(lambda number=number: book(number) for number in range(2)),  # type: ignore[misc]
    )
    with ThreadPoolExecutor(len(work)) as threads:
        for done in [threads.submit(one) for one in work]:
            done.result()
    return booked
