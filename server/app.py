"""The composition root: the only file that sees every room of the server.

`create_app(settings, ports)` is the same live and in virtual time; what differs comes in by the ports.
"""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field

import structlog
from fastapi import FastAPI
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send

from contract.tracing import RideSpans, Spans
from server.api.metrics.measurements import Measurements
from server.api.metrics.request_durations import RequestDurations
from server.api.pages import page_response, read_pages
from server.api.plain_text_errors import PlainTextErrors
from server.api.request_ids import RequestIds
from server.api.rides.booking_batcher import BookingBatcher
from server.api.routers import bare_app
from server.api.security.access_watch import AccessWatch
from server.api.security.client_address import ClientAddresses
from server.api.security.headers import SecurityHeaders
from server.api.security.host_check import HostCheck
from server.api.security.open_sockets import OpenSockets
from server.api.security.rate_limit import RateLimit
from server.api.services import Limits, Services
from server.feeds.roads.workshop import RoadMapWorkshop
from server.fleet.hub import Hub
from server.fleet.presence import PresenceRelay
from server.live.camera_pictures import CameraPictures
from server.live.feed import SceneFeed
from server.live.onboard_scenes import OnboardScenes
from server.loops.departures import DepartureScheduler
from server.loops.dispatcher import Dispatcher
from server.loops.forks import InlineForks
from server.loops.outages import OutageRecorder
from server.loops.retention import RetentionLoop
from server.loops.ride_notices import RideNotices
from server.loops.series import SeriesScheduler
from server.loops.silence import SilenceMonitor
from server.loops.solver import InlineSolver
from server.loops.webhooks import WebhookDeliveries
from server.settings import PREFIX, Settings, SettingsError
from server.store.segments.choice import (
    open_scan_store,
    open_segment_store,
    open_tile_store,
    open_video_store,
)
from server.store.segments.segment_store import SegmentStore, SegmentStoreError
from server.supervision.retries import FAIL_AT_ONCE, RetryPolicy
from server.supervision.standing_tasks import StandingTask
from server.supervision.supervisor import Supervisor, tell_event_loop
from server.usecases.planning.forks import Forks
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock, Ids
from server.usecases.ports.offload import Offload
from server.usecases.ports.push import PushSender
from server.usecases.ports.solver import Solver
from server.usecases.ports.unit_of_work import Transactions
from server.usecases.ports.webhooks import WebhookSender

PASSWORD_CHECKS_MAX = 2

log = structlog.get_logger("server")


async def _nothing_to_close() -> None:
    return


@dataclass(frozen=True, slots=True)
class Ports:
    """Everything slow, random or outside.

    solver  where the dispatcher's long computations run; forks: where forks of the past do
    loops   standing tasks, started with the application
    retry   how failed standing tasks are repeated; in virtual time a failure ends the run
    end     ends the process because a standing task cannot do its work
    webhook_sender  None: nothing is sent to other networks, as in virtual time
    push_sender  None: nothing is sent to browsers
    spans   of rides; None: they are not traced
    makes_maps  one of the loops, here or in another process, makes point maps of scans
    has_our_tables  the database is at this version's migration; it may block
    close   called last, after every task has ended
    """

    campus_id: str
    clock: Clock
    ids: Ids
    transactions: Transactions
    bus: Bus
    offload: Offload
    solver: Solver = field(default_factory=InlineSolver)
    forks: Forks = field(default_factory=InlineForks)
    loops: tuple[StandingTask, ...] = ()
    retry: RetryPolicy = FAIL_AT_ONCE
    end: Callable[[str, BaseException], None] = tell_event_loop
    webhook_sender: WebhookSender | None = None
    push_sender: PushSender | None = None
    spans: Spans | None = None
    makes_maps: bool = False
    has_our_tables: Callable[[], bool] = lambda: True
    close: Callable[[], Awaitable[None]] = field(default=_nothing_to_close)


def create_app(settings: Settings, ports: Ports) -> FastAPI:
    """The whole server as an ASGI application. Its tasks run while its lifespan does.

    Raises SettingsError.
    """
    services = _services(settings, ports)
    app = bare_app(lifespan=_lifespan(services, ports))
    app.state.services = services
    app.add_middleware(PlainTextErrors)
    app.add_middleware(RequestDurations, requests=services.measurements.requests)
    app.add_middleware(OpenSockets, per_client_max=settings.connections_per_address_max)
    if settings.hosts():
        app.add_middleware(HostCheck, hosts=settings.hosts())
    app.add_middleware(SecurityHeaders, with_tls=settings.has_tls())
    # Outside of all that go by the client's address.
    app.add_middleware(ClientAddresses, trusted=settings.proxies(), header=settings.forwarded_header)
    # The outermost: every answer has an id.
    app.add_middleware(RequestIds, ids=ports.ids)
    app.router.default = _pages(services, app.router.default)
    return app


def standing_tasks(ports: Ports) -> tuple[StandingTask, ...]:
    """The loops that run beside the endpoints, over the same ports."""
    transactions, ids, sender = ports.transactions, ports.ids, ports.webhook_sender
    tasks: tuple[StandingTask, ...] = (
        Dispatcher(transactions, ports.bus, ports.solver, ids, ports.campus_id).task,
        DepartureScheduler(transactions, ids.new_id("departures")).task,
        SeriesScheduler(transactions, ids.new_id("series-clerk")).task,
        SilenceMonitor(transactions).task,
        RetentionLoop(transactions).task,
    )
    if sender is not None:
        holder = ids.new_id("webhooks")
        tasks += (WebhookDeliveries(transactions, sender, ports.clock, ids, holder).task,)
    if ports.push_sender is not None:
        tasks += (RideNotices(transactions, ports.push_sender, ports.clock).task,)
    return tasks


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
    supervisor = Supervisor(ports.clock, ports.ids, ports.retry, ports.end)
    spans = None if ports.spans is None else RideSpans(ports.spans)
    hub = Hub(
        ports.campus_id,
        ports.clock,
        ports.ids,
        ports.transactions,
        ports.bus,
        supervisor,
        settings.hello_timeout_s,
        spans,
    )
    return Services(
        campus_id=ports.campus_id,
        settings=settings,
        clock=ports.clock,
        ids=ports.ids,
        transactions=ports.transactions,
        bookings=BookingBatcher(ports.transactions, ports.clock, spans),
        bus=ports.bus,
        offload=ports.offload,
        segments=_segments(settings),
        tiles=_tiles(settings),
        scans=_scans(settings),
        videos=_videos(settings),
        hub=hub,
        presence=PresenceRelay(ports.campus_id, ports.clock, ports.transactions, ports.bus),
        feed=SceneFeed(
            ports.campus_id,
            ports.clock,
            ports.transactions,
            ports.bus,
            supervisor,
            settings.live_interval_s,
        ),
        onboard=OnboardScenes(ports.campus_id, ports.clock, ports.bus),
        cameras=CameraPictures(ports.campus_id, ports.clock, ports.bus),
        supervisor=supervisor,
        measurements=Measurements(ports.clock, hub, supervisor),
        access=AccessWatch(ports.campus_id, ports.clock, ports.bus, supervisor),
        limits=Limits(
            logins=RateLimit(settings.login_tries_per_minute),
            known_logins=RateLimit(settings.login_tries_per_minute),
            account_logins=RateLimit(settings.account_login_tries_per_minute),
            lookups=RateLimit(settings.lookups_per_minute),
            bookings=RateLimit(settings.bookings_per_minute),
            offers=RateLimit(settings.offers_per_minute),
            commands=RateLimit(settings.commands_per_minute),
            second_factors=RateLimit(settings.second_factor_tries_per_minute),
            password_checks=asyncio.Semaphore(PASSWORD_CHECKS_MAX),
        ),
        has_our_tables=ports.has_our_tables,
        makes_maps=ports.makes_maps,
        maps=RoadMapWorkshop(),
        forks=ports.forks,
        webhook_sender=ports.webhook_sender,
        push_sender=ports.push_sender,
        spans=spans,
        pages=read_pages(settings.web_dist),
    )


def _segments(settings: Settings) -> SegmentStore:
    try:
        return open_segment_store(settings.segments_url, settings.var_dir, settings.segment_bytes_max)
    except SegmentStoreError as error:
        raise SettingsError(f"{PREFIX}SEGMENTS_URL: {error}") from error


def _tiles(settings: Settings) -> SegmentStore:
    try:
        return open_tile_store(settings.segments_url, settings.var_dir)
    except SegmentStoreError as error:
        raise SettingsError(f"{PREFIX}SEGMENTS_URL: {error}") from error


def _scans(settings: Settings) -> SegmentStore:
    try:
        return open_scan_store(settings.segments_url, settings.var_dir)
    except SegmentStoreError as error:
        raise SettingsError(f"{PREFIX}SEGMENTS_URL: {error}") from error


def _videos(settings: Settings) -> SegmentStore:
    try:
        return open_video_store(settings.segments_url, settings.var_dir)
    except SegmentStoreError as error:
        raise SettingsError(f"{PREFIX}SEGMENTS_URL: {error}") from error


def _lifespan(services: Services, ports: Ports) -> Callable[[FastAPI], AbstractAsyncContextManager[None]]:
    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with AsyncExitStack() as stack:
            stack.push_async_callback(ports.close)
            await services.feed.start()
            stack.push_async_callback(services.feed.close)
            for reader in (services.onboard.reader, services.cameras.reader):
                await reader.subscribe()
                services.supervisor.start(reader)
            await services.access.start()
            await services.hub.start()
            stack.push_async_callback(services.hub.close)
            supervisor, name = services.supervisor, services.settings.server_name
            for task in ports.loops:
                supervisor.start(task)
            supervisor.start(OutageRecorder(ports.transactions, supervisor, name).task)
            stack.push_async_callback(supervisor.close)
            log.info("server.started", campus_id=ports.campus_id, loops=len(ports.loops))
            yield
            log.info("server.stopping")

    return lifespan
