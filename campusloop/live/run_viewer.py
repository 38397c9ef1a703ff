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
        server = uvicorn.Server(uvicorn_config(settings, await live_ports(settings)))
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        try:
            await _until_started(server)
            async with httpx.AsyncClient(base_url=settings.origin(), timeout=TIMEOUT_S) as client:
                await _upload(runs, client, password)
            _print_addresses(runs, settings.origin(), password, report)
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


def _print_addresses(
    runs: tuple[ViewedRun, ...], origin: str, password: str, report: Callable[[str], None]
) -> None:
    report(f"operator's name: {OPERATOR}   password: {password}")
    for name in dict.fromkeys(f"{run.vehicle_id}/{run.boot_id}" for run in runs):
        report(f"{origin}/console#/runs/{name}")
    report("Ctrl-C stops it")
