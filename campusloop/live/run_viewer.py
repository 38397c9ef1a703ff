"""Run logs from a folder in the web viewer: a server of their own that holds nothing else."""

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


class NothingToView(Exception):
    """There are no run logs, or they cannot be taken in; the message says what to do."""


@dataclass(frozen=True, slots=True)
class ViewedRun:
    """One segment's file and whose it is."""

    path: Path
    vehicle_id: str
    boot_id: str


def runs_in(places: tuple[Path, ...]) -> tuple[ViewedRun, ...]:
    """Every segment named or anywhere below a folder named, by path. Raises NothingToView."""
    found: list[ViewedRun] = []
    for place in places:
        paths = sorted(place.rglob("*.mcap")) if place.is_dir() else [place]
        if not paths:
            raise NothingToView(f"{place}: no run logs (*.mcap) there")
        for path in paths:
            try:
                header = open_segment(path).header
            except RunLogError as error:
                raise NothingToView(str(error)) from error
            found.append(ViewedRun(path, header.vehicle_id, header.boot_id))
    return tuple(found)


async def view(runs: tuple[ViewedRun, ...], port: int, tell: Callable[[str], None]) -> None:
    """Serve these runs on this machine until Ctrl-C. Raises NothingToView, CannotStart, OperatorError."""
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
        server = uvicorn.Server(uvicorn_config(settings, await live_ports(settings)))
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        try:
            await _until_started(server)
            async with httpx.AsyncClient(base_url=settings.origin(), timeout=TIMEOUT_S) as client:
                await _take_in(runs, client, password)
            _greet(runs, settings.origin(), password, tell)
            await serving
        finally:
            server.should_exit = True
            await serving


async def _until_started(server: uvicorn.Server) -> None:
    for _ in range(round(_START_S / _POLL_S)):
        if server.started:
            return
        await asyncio.sleep(_POLL_S)
    raise NothingToView(f"the viewer's server did not come up within {_START_S:.0f} s")


async def _take_in(runs: tuple[ViewedRun, ...], client: httpx.AsyncClient, password: str) -> None:
    """As the vehicles themselves would: enrolled, and every segment signed."""
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
            raise NothingToView(f"{run.path}: {answer.json().get('detail')}")


def _greet(runs: tuple[ViewedRun, ...], origin: str, password: str, tell: Callable[[str], None]) -> None:
    tell(f"operator's name: {OPERATOR}   password: {password}")
    for name in dict.fromkeys(f"{run.vehicle_id}/{run.boot_id}" for run in runs):
        tell(f"{origin}/console#/runs/{name}")
    tell("Ctrl-C stops it")
