"""The server as a process in virtual time: started on a store, ended in an orderly way or by a crash."""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import httpx
from fastapi import FastAPI

from campusloop.simulation.clocks import WallClock
from campusloop.simulation.process.store import ProcessTransactions, SimulatedDatabase, StoreFaults
from campusloop.simulation.timeline import Timeline
from campusloop.virtual.campus import OPERATOR, ORIGIN, TICKET_KEYS, QuickHasher
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from server.adapters import SeededIds
from server.api.runs.offload import InlineOffload
from server.api.services import Services
from server.app import Ports, create_app, services_of_app, standing_tasks
from server.bus.in_process import InProcessBus
from server.domain.errors import StoreFailure
from server.domain.rules import FleetRules
from server.settings import settings_from
from server.store.roads.map_library import MapLibrary
from server.store.transactions import InlineTransactions
from server.store.unit_of_work import Context
from server.supervision.retries import RetryPolicy
from server.usecases.fleet import campus
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity

TRIES_PER_MINUTE = 100_000
# No page is open: the scene is kept, but not as often as a viewer's eye wants it.
LIVE_INTERVAL_S = 10.0


@dataclass(frozen=True, slots=True)
class Machine:
    """What outlives a server process: its disk, its clock, and chance.

    library  the decoded maps, which never change: decoding them again would only take time
    """

    timeline: Timeline
    road_map: RoadMap
    folder: Path
    database: SimulatedDatabase
    clock: WallClock
    ids: SeededIds
    rules: FleetRules
    library: MapLibrary

    def context(self) -> Context:
        return Context(
            self.road_map.campus_id,
            self.clock,
            self.ids,
            self.rules,
            QuickHasher(),
            self.library,
            TICKET_KEYS,
        )


class ServiceProcess:
    """One life of the server. `on_end(cause)` is called when a fault or the server itself ends it.

    defects  what went wrong inside that no failure of the store explains
    """

    def __init__(self, machine: Machine, faults: StoreFaults, on_end: Callable[[str], None]) -> None:
        self._timeline = machine.timeline
        self.loop = machine.timeline.new_loop()
        self.loop.call_exception_handler = self._failed  # type: ignore[method-assign]
        self.defects: list[str] = []
        self.is_over = False
        self._on_end = on_end
        bus = InProcessBus()
        self._inline = InlineTransactions(machine.database.engine, machine.context(), bus)
        rng = machine.timeline.rng(f"store {machine.timeline.now_ns}")
        self.transactions = ProcessTransactions(self._inline, faults, rng, self.crash)
        ports = Ports(
            machine.road_map.campus_id,
            machine.clock,
            machine.ids,
            self.transactions,
            bus,
            InlineOffload(),
            retry=RetryPolicy(),
            end=self._given_up,
        )
        self._app = create_app(_settings(machine.folder), replace(ports, loops=standing_tasks(ports)))
        self._watch_inputs()
        self._transport = httpx.ASGITransport(app=self._app)
        self._stopping = asyncio.Event()
        self._life = self.loop.create_task(self._live(self._app), name="life")

    @property
    def services(self) -> Services:
        return services_of_app(self._app)

    def running_tasks(self) -> "set[asyncio.Task[Any]]":
        """The tasks of this process that have not ended."""
        return asyncio.all_tasks(self.loop)

    async def handle(self, request: httpx.Request) -> httpx.Response:
        """Answer a request, inside this process."""
        return await self._transport.handle_async_request(request)

    def crash(self, cause: str) -> None:
        """The process ends at once: its memory is lost, and none of its tasks does anything more."""
        if self.is_over:
            return
        self.is_over = True
        self.transactions.is_over = True
        self._on_end(cause)
        self._timeline.at(self._timeline.now_ns, self.end_tasks)

    def end_tasks(self) -> None:
        """Cancel every task of the process and forget its loop.

        Their transactions raise CancelledError, so nothing of this reaches the store.
        """
        self.is_over = self.transactions.is_over = True
        for task in sorted(asyncio.all_tasks(self.loop), key=lambda task: task.get_name()):
            task.cancel()
        self.loop.run_now(self._inline.close())
        self._timeline.remove_loop(self.loop)
        self.loop.close()

    def _watch_inputs(self) -> None:
        """A message that a standing task cannot handle is a defect, though the task goes on."""
        supervisor = self.services.supervisor
        take = supervisor.input_failed

        def input_failed(name: str, error: Exception) -> None:
            if not self.is_over and not _is_of_store(error):
                self.defects.append(f"{name} cannot handle an input: {error!r}")
            take(name, error)

        supervisor.input_failed = input_failed  # type: ignore[method-assign]

    def _given_up(self, text: str, error: BaseException) -> None:
        if not _is_of_store(error):
            self.defects.append(text)
        self.crash("gave up")

    def _failed(self, context: Mapping[str, object]) -> None:
        error = context.get("exception")
        if self.is_over or (isinstance(error, BaseException) and _is_of_store(error)):
            return
        self.defects.append(f"{context.get('message')}: {error!r}")

    async def _live(self, app: FastAPI) -> None:
        async with app.router.lifespan_context(app):
            await self._stopping.wait()


def prepare(machine: Machine) -> None:
    """What the server does with its database before it serves: the map, and an operator who can sign in."""

    def work(uow: UnitOfWork) -> None:
        campus.load_map_at_start(uow, encode_map(machine.road_map))
        identity.set_password(uow, *OPERATOR)

    transactions = InlineTransactions(machine.database.engine, machine.context(), InProcessBus())
    loop = machine.timeline.new_loop()
    loop.run_now(transactions.run(work))
    machine.timeline.remove_loop(loop)


def _is_of_store(error: BaseException) -> bool:
    if isinstance(error, BaseExceptionGroup):
        return all(_is_of_store(inner) for inner in error.exceptions)
    return isinstance(error, StoreFailure)


def _settings(folder: Path) -> Any:
    return settings_from(
        {},
        var_dir=folder,
        public_url=ORIGIN,
        live_interval_s=LIVE_INTERVAL_S,
        login_tries_per_minute=TRIES_PER_MINUTE,
        lookups_per_minute=TRIES_PER_MINUTE,
        bookings_per_minute=TRIES_PER_MINUTE,
    )
