"""The whole server in virtual time over SQLite in memory, with requests through in-memory ASGI."""

import copy
import json
import sqlite3
from collections.abc import Coroutine
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import httpx
from sqlalchemy import Engine

from campusloop.virtual.conductor import Conductor
from contract.roads.load import encode_map, load_map
from contract.roads.model import RoadMap
from server.adapters import SeededIds
from server.api.runs.offload import InlineOffload
from server.app import Ports, create_app, services_of_app
from server.bus.in_process import InProcessBus
from server.domain.rules import FleetRules
from server.settings import Settings
from server.store.engine import open_engine
from server.store.tables import metadata
from server.store.transactions import InlineTransactions
from server.store.unit_of_work import Context
from server.supervision.retries import FAIL_AT_ONCE, RetryPolicy
from server.usecases.fleet import campus
from server.usecases.ports.push import PushSender
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from tests.server.usecases.campus_under_test import TICKET_KEYS, map_library
from tests.server.usecases.fresh_database import fill, taken_copy

T = TypeVar("T")
_free_engines: list[Engine] = []
START = datetime(2026, 9, 1, 8, 0, tzinfo=UTC)
MAPS = Path(__file__).resolve().parents[3] / "maps"
CAMPUS = "snow-lion"
PASSWORD = "correct horse battery"


class ConductedClock:
    """Server time is START plus virtual time."""

    def __init__(self, conductor: Conductor) -> None:
        self._conductor = conductor

    def now(self) -> datetime:
        return START + timedelta(microseconds=self._conductor.now_ns // 1000)


class PlainHasher:
    """Quick, and readable in a failing test."""

    def hash(self, password: str) -> str:
        return f"plain:{password}"

    def verify(self, password_hash: str, password: str) -> bool:
        return password_hash == f"plain:{password}"


def snow_lion() -> RoadMap:
    return load_map(MAPS / "snow-lion" / "map.json")


class ServerUnderTest:
    """Start it, send requests, let time pass."""

    def __init__(
        self,
        var_dir: Path,
        rules: FleetRules | None = None,
        with_map: bool = True,
        retry: RetryPolicy = FAIL_AT_ONCE,
        is_watched: bool = True,
        push_sender: PushSender | None = None,
        makes_maps: bool = False,
        **settings: Any,
    ) -> None:
        """is_watched: a screen is open all the time."""
        self.conductor = Conductor(1)
        self.clock = ConductedClock(self.conductor)
        self.bus = InProcessBus()
        self.settings = Settings(var_dir=var_dir, web_dist=var_dir / "dist", **settings)
        rules = rules or FleetRules()
        self._engine, ids = _prepared(with_map)
        context = Context(CAMPUS, self.clock, ids, rules, PlainHasher(), map_library(rules), TICKET_KEYS)
        self.transactions = InlineTransactions(self._engine, context, self.bus)
        ports = Ports(
            CAMPUS,
            self.clock,
            SeededIds(1),
            self.transactions,
            self.bus,
            InlineOffload(),
            retry=retry,
            push_sender=push_sender,
            makes_maps=makes_maps,
        )
        self.app = create_app(self.settings, ports)
        self.services = services_of_app(self.app)
        self.hub = self.services.hub
        self._lifespan = self.app.router.lifespan_context(self.app)
        self.run(self._lifespan.__aenter__())
        self._screen = self.services.feed.watched()
        if is_watched:
            self.run(self._screen.__aenter__())
        self.client = httpx.AsyncClient(
            transport=httpx.ASGITransport(self.app), base_url="http://campus.test"
        )

    def run(self, work: Coroutine[Any, Any, T]) -> T:
        return self.conductor.loop.run_now(work)

    def close(self) -> None:
        self.run(self._lifespan.__aexit__(None, None, None))
        self.run(self.transactions.close())
        _free_engines.append(self._engine)

    def from_host(self, host: str) -> None:
        """Requests come from this address from now on."""
        self.client = httpx.AsyncClient(
            transport=httpx.ASGITransport(self.app, client=(host, 50_000)), base_url="http://campus.test"
        )

    def elapse(self, seconds: float) -> None:
        self.conductor.run_for(seconds)

    def transact(self, work: Any) -> Any:
        return self.run(self.transactions.run(work))

    def request(self, method: str, path: str, **options: Any) -> httpx.Response:
        return self.run(self.client.request(method, f"/api/v1{path}", **options))

    def raw(self, method: str, path: str, **options: Any) -> httpx.Response:
        """A path outside of the API."""
        return self.run(self.client.request(method, path, **options))

    def get(self, path: str, **options: Any) -> httpx.Response:
        return self.request("GET", path, **options)

    def post(self, path: str, body: object = None, **options: Any) -> httpx.Response:
        if body is not None:
            options["content"] = json.dumps(body)
            options["headers"] = {"Content-Type": "application/json", **options.get("headers", {})}
        return self.request("POST", path, **options)

    def sign_in(self) -> dict[str, str]:
        """The headers that a change needs; the cookie stays in the client."""
        answer = self.post("/session", {"name": "operator", "password": PASSWORD})
        assert answer.status_code == 200, answer.text
        return {"X-CSRF-Token": answer.json()["csrf_token"]}

    def enrol(self, vehicle_id: str, public_key: str) -> None:
        def work(uow: UnitOfWork) -> str:
            return identity.create_enrolment_code(
                uow, vehicle_id, vehicle_id.title(), "operator", seats=6, wheelchair_places=0
            )

        code = self.transact(work)
        answer = self.post("/enrolments", {"code": code, "vehicle_id": vehicle_id, "public_key": public_key})
        assert answer.status_code == 201, answer.text


def _prepared(with_map: bool) -> tuple[Engine, SeededIds]:
    """A database of its own with the operator and the map in it, and the ids that come next.

    A copy, in the engine of a server that has ended: to fill one, and to compile its statements, takes longer
    than most tests.
    """
    filled, ids = _filled(with_map)
    engine = _free_engines.pop() if _free_engines else open_engine("sqlite://")
    fill(engine, filled)
    return engine, copy.deepcopy(ids)


@cache
def _filled(with_map: bool) -> tuple[sqlite3.Connection, SeededIds]:
    engine, ids, conductor = open_engine("sqlite://"), SeededIds(2), Conductor(1)
    metadata.create_all(engine)
    rules = FleetRules()
    context = Context(
        CAMPUS, ConductedClock(conductor), ids, rules, PlainHasher(), map_library(rules), TICKET_KEYS
    )

    def work(uow: UnitOfWork) -> None:
        identity.set_password(uow, "operator", PASSWORD)
        if with_map:
            campus.load_map(uow, encode_map(snow_lion()), "test", activate=True)

    conductor.loop.run_now(InlineTransactions(engine, context, InProcessBus()).run(work))
    return taken_copy(engine), ids
