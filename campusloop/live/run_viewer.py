"""Run logs from a folder in the web viewer, on a temporary server."""

import asyncio
import hashlib
import secrets
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import httpx
import uvicorn
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from campusloop.clients.operator_client import OperatorClient
from campusloop.live.server import listen, uvicorn_config
from campusloop.shipped import DEFAULT_MAP
from contract.runlog.reader import RunLogError, open_segment
from server.live_ports import live_ports
from server.settings import settings_from
from vehicle_agent.config import Body
from vehicle_agent.link.keys import public_key_text, signature_text
from vehicle_agent.link.upload import TIMEOUT_S, put_segment

OPERATOR = "operator"
_POLL_S = 0.1
_START_S = 60.0


class RunViewError(Exception):
    """There are no run logs, or they cannot be loaded; the message says what to do."""


@dataclass(frozen=True, slots=True)
class ViewedRun:
    """One segment's file, its vehicle and its boot."""

    path: Path
    vehicle_id: str
    boot_id: str


def runs_in(places: tuple[Path, ...]) -> tuple[ViewedRun, ...]:
    """The given segments and those below the given folders, by path. Raises RunViewError."""
    found: list[ViewedRun] = []
    for place in places:
        paths = sorted(place.rglob("*.mcap")) if place.is_dir() else [place]
        if not paths:
            raise RunViewError(f"{place}: no run logs (*.mcap) there")
        for path in paths:
            try:
                header = open_segment(path).header
            except RunLogError as error:
                raise RunViewError(str(error)) from error
            found.append(ViewedRun(path, header.vehicle_id, header.boot_id))
    return tuple(found)


async def view(runs: tuple[ViewedRun, ...], port: int, report: Callable[[str], None]) -> None:
    """Serve these runs on this machine until Ctrl-C. Raises RunViewError, CannotStart, OperatorError."""
    with tempfile.TemporaryDirectory(prefix="campusloop-view-") as var:
        password = secrets.token_urlsafe(6)
        listening = listen("127.0.0.1", port)
        settings = settings_from(
            {},
            port=listening.getsockname()[1],
            var_dir=Path(var),
            map_path=DEFAULT_MAP,
            operator_name=OPERATOR,
            operator_password=password,
            with_loops=False,
        )
        config = uvicorn_config(settings, await live_ports(settings))
        door = _Door(config.app, _first_page(runs))  # type: ignore[arg-type]
        config.app = door
        server = uvicorn.Server(config)
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        try:
            await _until_started(server)
            async with httpx.AsyncClient(base_url=settings.origin(), timeout=TIMEOUT_S) as client:
                await _upload(runs, client, password)
                door.cookies = await _session_cookies(client, password)
            _print_addresses(runs, settings.origin(), report)
            await serving
        finally:
            server.should_exit = True
            await serving


async def _until_started(server: uvicorn.Server) -> None:
    for _ in range(round(_START_S / _POLL_S)):
        if server.started:
            return
        await asyncio.sleep(_POLL_S)
    raise RunViewError(f"the viewer's server was not ready within {_START_S:.0f} s")


async def _upload(runs: tuple[ViewedRun, ...], client: httpx.AsyncClient, password: str) -> None:
    """Enrol the vehicles and upload every segment, signed, as the vehicles would."""
    operator = OperatorClient(client)
    await operator.sign_in(OPERATOR, password)
    keys: dict[str, Ed25519PrivateKey] = {}
    for run in runs:
        key = keys.get(run.vehicle_id)
        if key is None:
            key = keys[run.vehicle_id] = Ed25519PrivateKey.generate()
            await operator.enrol(run.vehicle_id, Body(), public_key_text(key))
        data = run.path.read_bytes()
        sha256 = hashlib.sha256(data).hexdigest()
        answer = await put_segment(client, run.vehicle_id, partial(signature_text, key), data, sha256)
        if answer.is_error:
            raise RunViewError(f"{run.path}: {answer.json().get('detail')}")


async def _session_cookies(client: httpx.AsyncClient, password: str) -> tuple[str, ...]:
    """What a browser gets that signs in, as Set-Cookie headers."""
    answer = await client.post("/api/v1/session", json={"name": OPERATOR, "password": password})
    if answer.is_error:
        raise RunViewError(f"the viewer cannot sign in: {answer.text}")
    return tuple(answer.headers.get_list("set-cookie"))


class _Door:
    """The server whose root is the replay, without a password.

    It listens on loopback only, on the machine of a person who may read these files. The host of a request is
    checked as everywhere, so that no page of another site gets a session under a name of its own.
    """

    def __init__(self, app: ASGIApp, first_page: str) -> None:
        self._app, self._first_page = app, first_page
        self.cookies: tuple[str, ...] = ()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        is_root = scope["type"] == "http" and scope["path"] == "/" and scope["method"] == "GET"
        if not is_root or not self.cookies or not _is_loopback_host(scope):
            await self._app(scope, receive, send)
            return
        answer = RedirectResponse(self._first_page, status_code=303, headers={"Cache-Control": "no-store"})
        for cookie in self.cookies:
            answer.headers.append("set-cookie", cookie)
        await answer(scope, receive, send)


def _is_loopback_host(scope: Scope) -> bool:
    host = dict(scope["headers"]).get(b"host", b"").decode("latin-1").rsplit(":", 1)[0]
    return host in ("127.0.0.1", "localhost")


def _names(runs: tuple[ViewedRun, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(f"{run.vehicle_id}/{run.boot_id}" for run in runs))


def _first_page(runs: tuple[ViewedRun, ...]) -> str:
    """The replay of the only run, or the list of several. The query makes the page ask for its session."""
    names = _names(runs)
    return f"/console?signed-in#/runs/{names[0]}" if len(names) == 1 else "/console?signed-in#/runs"


def _print_addresses(runs: tuple[ViewedRun, ...], origin: str, report: Callable[[str], None]) -> None:
    count = len(_names(runs))
    report(f"{origin}/   the replay" if count == 1 else f"{origin}/   {count} runs to choose from")
    report("Ctrl-C stops it")
