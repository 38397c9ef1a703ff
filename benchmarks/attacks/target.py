"""A served campus in this process, with everyone who may come to it: so that a control can be taken away."""

import asyncio
import base64
import sqlite3
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import Any, TypeVar

import httpx
import uvicorn
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from campusloop.live.server import listen, uvicorn_config
from contract.wire.messages import Hello, signed_hello
from server.domain.record.identity import Role, Scope
from server.live_ports import LivePorts, live_ports
from server.settings import Settings
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record import identity
from server.usecases.record.operators import operators

T = TypeVar("T")

MAP = Path(__file__).resolve().parents[2] / "maps" / "snow-lion" / "map.json"
PASSWORD = "attacks are tried on purpose"
OWN_PASSWORD = "a password of one's own"
STOPS = ("NN7", "C6")
ROLES: tuple[Role, ...] = ("viewer", "dispatcher", "safety", "admin")
GENEROUS = {
    "login_tries_per_minute": 1_000_000,
    "account_login_tries_per_minute": 1_000_000,
    "lookups_per_minute": 1_000_000,
    "bookings_per_minute": 1_000_000,
    "commands_per_minute": 1_000_000,
    "second_factor_tries_per_minute": 1_000_000,
}
STARTED_WITHIN_S = 60.0


@dataclass
class Session:
    """What a signed-in browser sends."""

    token: str

    @property
    def cookie(self) -> dict[str, str]:
        return {"Cookie": f"campusloop_session={self.token}"}

    @property
    def csrf(self) -> dict[str, str]:
        return {"X-CSRF-Token": identity.csrf_token_of(self.token)}

    @property
    def headers(self) -> dict[str, str]:
        return self.cookie | self.csrf


@dataclass
class Target:
    """`http` keeps no cookies between requests."""

    settings: Settings
    live: LivePorts
    http: httpx.AsyncClient
    keys: dict[str, Ed25519PrivateKey] = field(default_factory=dict)
    _number: int = 0

    @property
    def transactions(self) -> Transactions:
        return self.live.ports.transactions

    @property
    def database(self) -> Path:
        return self.settings.var_dir / "campusloop.db"

    def websocket(self, path: str) -> str:
        return f"ws://127.0.0.1:{self.settings.port}{path}"

    async def do(self, work: Callable[[UnitOfWork], T]) -> T:
        return await self.transactions.run(work)

    async def ask(
        self, method: str, path: str, headers: dict[str, str] | None = None, **options: Any
    ) -> httpx.Response:
        self.http.cookies.clear()
        return await self.http.request(method, f"/api/v1{path}", headers=headers, **options)

    def fresh(self, what: str) -> str:
        self._number += 1
        return f"{what}-{self._number}"

    async def operator(self, *roles: Role, initial: bool = False) -> str:
        """Its name; the password is OWN_PASSWORD."""
        name, hasher = self.fresh("operator"), await self.transactions.read(lambda uow: uow.hasher)
        password_hash = hasher.hash(OWN_PASSWORD)

        def work(uow: UnitOfWork) -> None:
            made = operators.create(uow, name, roles, password_hash, "attacks")
            if not initial:
                operators.choose_password(uow, made, "", password_hash)

        await self.do(work)
        return name

    async def session_of(self, name: str) -> Session:
        def work(uow: UnitOfWork) -> str:
            return identity.open_operator_session(uow, operators.operator_named(uow, name)).token

        return Session(await self.do(work))

    async def session(self, *roles: Role, initial: bool = False) -> Session:
        return await self.session_of(await self.operator(*roles, initial=initial))

    async def token(self, *scopes: Scope, valid_s: float = 3600.0) -> identity.CreatedToken:
        name = self.fresh("token")
        return await self.do(
            lambda uow: identity.create_developer_token(uow, name, scopes, valid_s, "attacks")
        )

    async def revoked(self, *scopes: Scope) -> str:
        made = await self.token(*scopes)
        await self.do(lambda uow: identity.revoke_developer_token(uow, made.token.token_id, "attacks"))
        return made.secret

    async def expired(self, *scopes: Scope) -> str:
        return (await self.token(*scopes, valid_s=-1.0)).secret

    async def book(self) -> dict[str, Any]:
        """A ride by a passenger, as its answer tells it."""
        soon = (self.live.ports.clock.now() + timedelta(days=1)).isoformat()
        body = {"from_stop": STOPS[0], "to_stop": STOPS[1], "earliest": soon}
        answer = await self.ask("POST", "/rides", json=body)
        ride: dict[str, Any] = answer.json()
        return ride

    async def enrol(self) -> str:
        """A vehicle with a key of its own."""
        vehicle_id, key = self.fresh("vehicle"), Ed25519PrivateKey.generate()
        code = await self.do(
            lambda uow: identity.create_enrolment_code(
                uow, vehicle_id, vehicle_id, "attacks", seats=6, wheelchair_places=0
            )
        )
        body = {"code": code, "vehicle_id": vehicle_id, "public_key": public(key)}
        (await self.ask("POST", "/enrolments", json=body)).raise_for_status()
        self.keys[vehicle_id] = key
        return vehicle_id

    def change_rows(self, statement: str) -> None:
        """As one who writes the database by hand."""
        with sqlite3.connect(self.database, timeout=30.0) as connection:
            connection.execute(statement)
        connection.close()


def bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}


def public(key: Ed25519PrivateKey) -> str:
    return base64.b64encode(key.public_key().public_bytes_raw()).decode()


def hello(vehicle_id: str, key: Ed25519PrivateKey, nonce: str, map_version: str = "none") -> Hello:
    text = signed_hello(nonce, vehicle_id, "boot-1", 1)
    return Hello(
        protocol=1,
        vehicle_id=vehicle_id,
        boot_id="boot-1",
        nonce=nonce,
        signature=base64.b64encode(key.sign(text)).decode(),
        software="attacks",
        stack="none",
        map_version=map_version,
        vehicle_ns=1,
        seats=6,
    )


@asynccontextmanager
async def a_target(var_dir: Path, **settings: Any) -> AsyncIterator[Target]:
    """The server as `campusloop serve` runs it, on a free port of loopback."""
    listening = listen("127.0.0.1", 0)
    chosen = Settings(
        port=listening.getsockname()[1],
        var_dir=var_dir,
        web_dist=var_dir / "dist",
        map_path=MAP,
        operator_password=PASSWORD,
        allowed_hosts="campus.example",
        live_interval_s=0.05,
        **settings,
    )
    live = await live_ports(chosen)
    server = uvicorn.Server(uvicorn_config(chosen, live))
    serving = asyncio.get_running_loop().create_task(server.serve(sockets=[listening]))
    http = httpx.AsyncClient(base_url=chosen.origin(), trust_env=False, timeout=30.0)
    try:
        async with asyncio.timeout(STARTED_WITHIN_S):
            while not server.started:  # noqa: ASYNC110 - uvicorn has no event for it
                await asyncio.sleep(0.02)
        yield Target(chosen, live, http)
    finally:
        await http.aclose()
        server.should_exit = True
        await serving
