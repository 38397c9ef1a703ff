"""The composition root: the only file that sees every room of the server.

`create_app(settings, ports)` is the same live and in virtual time; what differs comes in by the ports.
"""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from typing import Protocol

import structlog
from fastapi import FastAPI
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send

from server.api.pages import page_response, read_pages
from server.api.plain_text_errors import PlainTextErrors
from server.api.rides.booking_batcher import BookingBatcher
from server.api.routers import bare_app
from server.api.runs.offload import Offload
from server.api.security.headers import SecurityHeaders
from server.api.security.rate_limit import RateLimit
from server.api.services import Limits, Services
from server.fleet.hub import Hub
from server.fleet.presence import PresenceRelay
from server.fleet.segment_files import SegmentFiles
from server.live.feed import SceneFeed
from server.loops.departures import DepartureScheduler
from server.loops.dispatcher import Dispatcher
from server.loops.retention import RetentionLoop
from server.loops.series import SeriesScheduler
from server.loops.silence import SilenceMonitor
from server.loops.solver import InlineSolver
from server.settings import Settings
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock, Ids
from server.usecases.ports.solver import Solver
from server.usecases.ports.unit_of_work import Transactions

log = structlog.get_logger("server")


class StandingTask(Protocol):
    """A loop that runs for as long as the server does, e.g. the dispatcher."""

    async def run(self) -> None: ...


async def _nothing_to_close() -> None:
    return


@dataclass(frozen=True, slots=True)
class Ports:
    """Everything slow, random or outside.

    solver  where the dispatcher's long computations run
    loops   standing tasks, started with the application
    close   called last, after every task has ended
    """

    campus_id: str
    clock: Clock
    ids: Ids
    transactions: Transactions
    bus: Bus
    offload: Offload
    solver: Solver = field(default_factory=InlineSolver)
    loops: tuple[StandingTask, ...] = ()
    close: Callable[[], Awaitable[None]] = field(default=_nothing_to_close)


def create_app(settings: Settings, ports: Ports) -> FastAPI:
    """The whole server as an ASGI application. Its tasks run while its lifespan does."""
    services = _services(settings, ports)
    app = bare_app(lifespan=_lifespan(services, ports))
    app.state.services = services
    app.add_middleware(PlainTextErrors)
    app.add_middleware(SecurityHeaders, with_tls=settings.has_tls())
    app.router.default = _pages(services, app.router.default)
    return app


def standing_tasks(ports: Ports) -> tuple[StandingTask, ...]:
    """The loops that run beside the endpoints, over the same ports."""
    transactions, ids = ports.transactions, ports.ids
    return (
        Dispatcher(transactions, ports.bus, ports.solver, ids, ports.campus_id),
        DepartureScheduler(transactions, ids.new_id("departures")),
        SeriesScheduler(transactions, ids.new_id("series-clerk")),
        SilenceMonitor(transactions),
        RetentionLoop(transactions),
    )


def services_of_app(app: FastAPI) -> Services:
    """For compositions that attach to the hub or read the scene without sockets."""
    services = app.state.services
    assert isinstance(services, Services)
    return services


def _pages(services: Services, otherwise: ASGIApp) -> ASGIApp:
    """Serve a page for every path without an endpoint, except paths of the API and of websockets."""

    async def pages(scope: Scope, receive: Receive, send: Send) -> None:
        path = scope.get("path", "")
        if scope["type"] != "http" or path.startswith(("/api/", "/ws/")):
            await otherwise(scope, receive, send)
            return
        request = Request(scope, receive)
        if request.method not in ("GET", "HEAD"):
            raise HTTPException(405, headers={"Allow": "GET, HEAD"})
        await page_response(services.pages, request)(scope, receive, send)

    return pages


def _services(settings: Settings, ports: Ports) -> Services:
    return Services(
        campus_id=ports.campus_id,
        settings=settings,
        clock=ports.clock,
        ids=ports.ids,
        transactions=ports.transactions,
        bookings=BookingBatcher(ports.transactions),
        bus=ports.bus,
        offload=ports.offload,
        segments=SegmentFiles(settings.var_dir / "segments", settings.segment_bytes_max),
        hub=Hub(
            ports.campus_id,
            ports.clock,
            ports.ids,
            ports.transactions,
            ports.bus,
            settings.hello_timeout_s,
        ),
        presence=PresenceRelay(ports.campus_id, ports.clock, ports.transactions, ports.bus),
        feed=SceneFeed(ports.campus_id, ports.clock, ports.transactions, ports.bus, settings.live_interval_s),
        limits=Limits(
            logins=RateLimit(settings.login_tries_per_minute),
            lookups=RateLimit(settings.lookups_per_minute),
            bookings=RateLimit(settings.bookings_per_minute),
        ),
        pages=read_pages(settings.web_dist),
    )


def _lifespan(services: Services, ports: Ports) -> Callable[[FastAPI], AbstractAsyncContextManager[None]]:
    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with AsyncExitStack() as stack:
            stack.push_async_callback(ports.close)
            await services.feed.start()
            stack.push_async_callback(services.feed.close)
            await services.hub.start()
            stack.push_async_callback(services.hub.close)
            tasks = [_standing(loop) for loop in ports.loops]
            stack.push_async_callback(_end, tasks)
            log.info("server.started", campus_id=ports.campus_id, loops=len(tasks))
            yield
            log.info("server.stopping")

    return lifespan


def _standing(loop: StandingTask) -> "asyncio.Task[None]":
    task = asyncio.get_running_loop().create_task(loop.run(), name=type(loop).__name__)
    task.add_done_callback(_report_failure)
    return task


async def _end(tasks: list["asyncio.Task[None]"]) -> None:
    for task in tasks:
        task.cancel()
    if tasks:
        await asyncio.wait(tasks)


def _report_failure(task: "asyncio.Task[None]") -> None:
    error = None if task.cancelled() else task.exception()
    if error is not None:
        log.error("loop.failed", loop=task.get_name(), exc_info=error)
        context = {"message": f"{task.get_name()} failed", "exception": error, "task": task}
        task.get_loop().call_exception_handler(context)
