"""The server as a live process: TLS, the listening socket and the settings for short response times."""

import asyncio
import errno
import gc
import os
import socket
import ssl
import sys
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import NoReturn

import uvicorn
import uvloop

from campusloop.live.certificate import local_addresses, self_signed
from campusloop.live.connections.bounded_http import counted_protocols
from campusloop.live.draining_server import draining_server
from campusloop.live.memory.allocator import (
    give_back_free_memory,
    keep_giving_back_memory,
    use_one_arena,
)
from campusloop.live.memory.library_pages import let_go_of_library_pages
from campusloop.live.paced_clock import PacedClock, PacedClocks
from campusloop.live.process_end import CANNOT_WORK, ProcessEnd
from campusloop.shipped import DEFAULT_MAP
from campusloop.telemetry.journal_console import journal_console
from campusloop.telemetry.otlp_spans import TracingUnavailable, span_source
from contract.tracing import Spans
from contract.wire.codec import MAX_MESSAGE_BYTES
from server.adapters import SystemClock
from server.api.security.connection_counts import ConnectionCounts
from server.app import create_app
from server.dispatch.warm import warm_kernels
from server.live_ports import CannotStart, LivePorts, live_ports
from server.settings import Settings, SettingsError, is_loopback, settings_from
from server.usecases.ports.clock_and_ids import Clock
from vehicle_agent.runtime.processes.journal import write_journal

BAD_SETTING = 2
BACKLOG = 512
_SWITCH_INTERVAL_S = 0.5e-3
_NEW_OBJECTS = 50_000
# How long a connection may be idle. Proxies keep theirs for 60 s, httpx for 5: who closes first must not be
# the server, or a request that is on its way at that moment is lost.
_IDLE_S_MAX = 75


def serve_campus(
    host: str | None = None,
    port: int | None = None,
    tls_cert: Path | None = None,
    tls_key: Path | None = None,
    campus_map: Path | None = None,
    *,
    tls_self_signed: bool = False,
    no_tls: bool = False,
    clocks: PacedClocks | None = None,
) -> None:
    """Serve one campus until SIGTERM or Ctrl-C. A bad setting ends the process with the reason.

    Arguments that are None come from the environment or the defaults (`server.settings`).
    clocks: None for the computer's clock
    """
    try:
        settings = secured(
            settings_from(
                os.environ, host=host, port=port, tls_cert=tls_cert, tls_key=tls_key, map_path=campus_map
            ),
            make_certificate=tls_self_signed,
            plain=no_tls,
        )
        if settings.map_path is None:
            settings = settings.model_copy(update={"map_path": DEFAULT_MAP})
        listening = listen(settings.host, settings.port)
        spans = span_source().open(settings.server_name)
    except (SettingsError, CannotStart, TracingUnavailable) as error:
        _refuse(str(error))
    write_journal(settings.server_name)
    use_one_arena()
    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        clock = SystemClock() if clocks is None else _CampusClock(clocks.open("server"))
        runner.run(_serve(settings, listening, clock, spans))
    if spans is not None:
        spans.close()


class _CampusClock:
    """The server's view of a clock that a whole campus shares."""

    def __init__(self, clock: PacedClock) -> None:
        self._clock = clock

    def now(self) -> datetime:
        return self._clock.utc()


def secured(settings: Settings, make_certificate: bool = False, plain: bool = False) -> Settings:
    """Settings with TLS for addresses other than loopback: as given, or self-signed under var/tls.

    Raises SettingsError if TLS is both requested and excluded, or cannot be used.
    """
    if plain and (make_certificate or settings.has_tls()):
        raise SettingsError("--no-tls contradicts a certificate; leave one of them out")
    if settings.has_tls():
        _check_certificate(settings)
        return settings
    if plain or (is_loopback(settings.host) and not make_certificate):
        return settings
    names = local_addresses(settings.host)
    certificate, key = self_signed(settings.var_dir / "tls", names)
    return settings.model_copy(update={"tls_cert": certificate, "tls_key": key})


def listen(host: str, port: int) -> socket.socket:
    """A listening socket. Raises CannotStart if the address is in use or not one of this machine's."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
        listening.listen(BACKLOG)
    except OSError as error:
        listening.close()
        if error.errno == errno.EADDRINUSE:
            raise CannotStart(f"port {port} on {host} is in use; stop what uses it or give --port") from error
        raise CannotStart(
            f"cannot listen on {host} port {port}: {error.strerror}; give another --host"
        ) from error
    listening.setblocking(False)
    return listening


async def _serve(settings: Settings, listening: socket.socket, clock: Clock, spans: Spans | None) -> None:
    settings = settings.model_copy(update={"port": listening.getsockname()[1]})
    end = ProcessEnd(journal_console(sys.stderr, "error"))
    try:
        solver_journal = partial(write_journal, f"{settings.server_name} solver")
        live = await live_ports(settings, clock, end.demand, solver_journal)
        live = replace(live, ports=replace(live.ports, spans=spans))
    except CannotStart as error:
        listening.close()
        _refuse(str(error))
    try:
        config = uvicorn_config(settings, live)
    except SettingsError as error:
        listening.close()
        await live.ports.close()
        _refuse(str(error))
    _print_addresses(settings, live)
    server = draining_server(config)
    end.stops(server)
    answer_promptly()
    keep_giving_back_memory()
    await server.serve(sockets=[listening])
    if end.text:
        raise SystemExit(CANNOT_WORK)


def answer_promptly() -> None:
    """Set up the process for short response times; call it when all objects are created.

    Loads the dispatcher's kernels, so that the first booking does not wait for them, and returns the memory
    that only the start needed.

    Shortens the switch interval: the store's writer thread releases the interpreter at every statement and
    would get it back only after Python's 5 ms. Freezes the present objects, which live until the end: with
    them, a garbage collection would stop the process for a quarter of a second.
    """
    warm_kernels()
    sys.setswitchinterval(_SWITCH_INTERVAL_S)
    gc.collect()
    give_back_free_memory()
    let_go_of_library_pages()
    gc.freeze()
    gc.set_threshold(_NEW_OBJECTS, 20, 20)


def uvicorn_config(settings: Settings, live: LivePorts) -> uvicorn.Config:
    """The configuration of every live server. Raises SettingsError."""
    counts = ConnectionCounts(settings.connections_per_address_max, settings.proxies())
    http, websocket = counted_protocols(counts)
    return uvicorn.Config(
        create_app(settings, live.ports),
        lifespan="on",
        http=http,
        limit_concurrency=settings.connections_max,
        ws=websocket,
        ws_per_message_deflate=False,
        ws_max_size=2 * MAX_MESSAGE_BYTES,  # above the protocol's limit, whose violation closes the session
        ssl_certfile=settings.tls_cert,
        ssl_keyfile=settings.tls_key,
        server_header=False,
        proxy_headers=False,
        access_log=False,  # a ride's link is a secret
        log_config=None,  # the process's own journal
        log_level="warning",
        timeout_keep_alive=_IDLE_S_MAX,
        timeout_graceful_shutdown=5,
    )


def _check_certificate(settings: Settings) -> None:
    assert settings.tls_cert is not None
    try:
        ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(
            settings.tls_cert, settings.tls_key
        )
    except (OSError, ssl.SSLError) as error:
        raise SettingsError(
            f"{settings.tls_cert} and {settings.tls_key} cannot be used for TLS ({error}); "
            "give a PEM certificate and its key, or --tls-self-signed"
        ) from error


def _print_addresses(settings: Settings, live: LivePorts) -> None:
    console = journal_console(sys.stderr)
    for name in local_addresses(settings.host):
        origin = settings.model_copy(update={"host": name}).origin()
        console.print(f"passengers  {origin}/\noperators   {origin}/console")
    if live.made_password:
        console.print(
            f"operator    {settings.operator_name}, password {live.made_password} (shown once; "
            "set CAMPUSLOOP_OPERATOR_PASSWORD to choose)"
        )


def _refuse(text: str) -> NoReturn:
    journal_console(sys.stderr, "error").print(f"campusloop serve: {text}", style="red", markup=False)
    raise SystemExit(BAD_SETTING)
