"""The live ports: database, bus, clock and chance as the settings name them, made ready to serve."""

import asyncio
import secrets
from collections.abc import Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass, replace
from urllib.parse import urlsplit

from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

from contract.roads.load import MapError, encode_map, load_map
from contract.roads.model import RoadMap
from server.adapters import Argon2Hasher, RandomIds, SystemClock
from server.api.runs.offload import ThreadOffload
from server.app import Ports, standing_tasks
from server.bus.in_process import InProcessBus
from server.domain.errors import DomainError
from server.domain.rides.ticket_keys import TicketKeys
from server.domain.rules import FleetRules
from server.domain.service.timetable import Opening, ServiceHours
from server.key_file import BadKeyFile
from server.loops.forks import ProcessForks
from server.loops.old_files import OldFilesLoop
from server.loops.scan_maps import ProcessMapBuilder, ScanMapLoop
from server.loops.solver import ProcessSolver
from server.push_encryption import PushIdentity
from server.push_key_file import push_identity_of
from server.push_sender import WebPushSender
from server.settings import Settings
from server.store.database_file import DatabaseInUse, database_file
from server.store.engine import DatabaseUnsupported, open_engine
from server.store.roads.map_library import MapLibrary
from server.store.schema import DatabaseTooNew, is_current, upgrade_to_head
from server.store.segments.choice import open_scan_store, open_tile_store, open_video_store
from server.store.segments.segment_store import SegmentStoreError
from server.store.transactions import GroupCommit
from server.store.unit_of_work import Context
from server.supervision.retries import RetryPolicy
from server.supervision.standing_tasks import StandingTask
from server.supervision.supervisor import tell_event_loop
from server.ticket_key_file import ticket_keys_of
from server.usecases.fleet import campus, old_scans, videos
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record import identity
from server.usecases.rides import tickets
from server.webhook_sender import HttpWebhookSender

DAY_S = 86_400
BUS_TIMEOUT_S = 5.0
NATS_PORT = 4222


class CannotStart(Exception):
    """The server cannot do its work with these settings; the text says what to do."""


@dataclass(frozen=True, slots=True)
class LivePorts:
    """made_password: of the first operator, when none was set; it is shown once."""

    ports: Ports
    made_password: str = ""


async def live_ports(
    settings: Settings,
    clock: Clock | None = None,
    end: Callable[[str, BaseException], None] = tell_event_loop,
    solver_begins: Callable[[], None] | None = None,
) -> LivePorts:
    """Migrate the database, activate the campus map, and make sure that an operator can sign in.

    clock  the system's if none is given
    end    ends the process, see `Ports`
    solver_begins  called first in the solver's process, e.g. to set up its log

    Raises CannotStart.
    """
    road_map = _road_map(settings)
    campus_id = settings.campus_id or road_map.campus_id
    rules = fleet_rules(settings, road_map)
    clock, ids = clock or SystemClock(), RandomIds()
    library, keys, push_identity = MapLibrary(rules), _ticket_keys(settings), _push_identity(settings)
    context = Context(campus_id, clock, ids, rules, Argon2Hasher(), library, keys)
    async with AsyncExitStack() as opened:
        engine = _engine(settings, opened)
        bus = await _bus(settings)
        opened.push_async_callback(bus.close)
        transactions = GroupCommit(engine, context, bus)
        opened.push_async_callback(transactions.close)
        solver = ProcessSolver(begins=solver_begins)
        opened.callback(solver.close)
        forks = ProcessForks(begins=solver_begins)
        opened.callback(forks.close)
        sender = HttpWebhookSender(settings.webhook_networks())
        opened.push_async_callback(sender.close)
        try:
            made_password = await _prepare(transactions, settings, road_map)
        except DomainError as error:
            raise CannotStart(f"{error.code}: {error.detail}") from error
        close = opened.pop_all().aclose
    ports = Ports(
        campus_id,
        clock,
        ids,
        transactions,
        bus,
        ThreadOffload(),
        solver,
        forks,
        retry=RetryPolicy(),
        end=end,
        webhook_sender=sender,
        push_sender=WebPushSender(push_identity, sender, settings.push_contact),
        makes_maps=True,
        has_our_tables=lambda: is_current(engine),
        close=close,
    )
    beside = (_scan_maps(settings, ports), *_old_files(settings, ports)) if settings.with_loops else ()
    loops = (*standing_tasks(ports), *beside) if settings.with_loops else ()
    return LivePorts(replace(ports, loops=loops), made_password)


def _scan_maps(settings: Settings, ports: Ports) -> StandingTask:
    """The loop that makes point maps of scans. Raises CannotStart."""
    try:
        scans = open_scan_store(settings.segments_url, settings.var_dir)
        tiles = open_tile_store(settings.segments_url, settings.var_dir)
    except SegmentStoreError as error:
        raise CannotStart(f"CAMPUSLOOP_SEGMENTS_URL: {error}") from error
    return ScanMapLoop(
        ports.transactions, ports.bus, ports.campus_id, ports.offload, scans, tiles, ProcessMapBuilder()
    ).task


def _old_files(settings: Settings, ports: Ports) -> tuple[StandingTask, ...]:
    """The loops that delete old video and old scans. Raises CannotStart."""
    try:
        video_store = open_video_store(settings.segments_url, settings.var_dir)
        scan_store = open_scan_store(settings.segments_url, settings.var_dir)
    except SegmentStoreError as error:
        raise CannotStart(f"CAMPUSLOOP_SEGMENTS_URL: {error}") from error
    kept = (
        ("videos", video_store, videos.outdated, videos.forget),
        ("scans", scan_store, old_scans.outdated, old_scans.forget),
    )
    return tuple(
        OldFilesLoop(what, ports.transactions, ports.offload, store, outdated, forget).task
        for what, store, outdated, forget in kept
    )


def _road_map(settings: Settings) -> RoadMap:
    if settings.map_path is None:
        raise CannotStart("no campus map: give one with --map, e.g. maps/shanghai-university/map.json")
    try:
        return load_map(settings.map_path)
    except MapError as error:
        raise CannotStart(f"{settings.map_path}: {error.detail}") from error


def _ticket_keys(settings: Settings) -> TicketKeys:
    try:
        return ticket_keys_of(settings.ticket_keys())
    except BadKeyFile as error:
        raise CannotStart(f"{error}; see CAMPUSLOOP_TICKET_KEY_FILE") from error
    except OSError as error:
        raise CannotStart(
            f"the ticket keys cannot be read or created ({error}); see CAMPUSLOOP_TICKET_KEY_FILE"
        ) from error


def _push_identity(settings: Settings) -> PushIdentity:
    try:
        return push_identity_of(settings.push_key())
    except BadKeyFile as error:
        raise CannotStart(f"{error}; see CAMPUSLOOP_PUSH_KEY_FILE") from error
    except OSError as error:
        raise CannotStart(
            f"the push key cannot be read or created ({error}); see CAMPUSLOOP_PUSH_KEY_FILE"
        ) from error


def _engine(settings: Settings, opened: AsyncExitStack) -> Engine:
    """The database, migrated. An SQLite file is locked before it is touched, until `opened` is closed."""
    settings.var_dir.mkdir(parents=True, exist_ok=True)
    url = settings.database()
    try:
        engine = open_engine(url)
        file = database_file(engine)
        if file is not None:
            file.lock()
            opened.callback(file.close)
        upgrade_to_head(engine)
    except (DatabaseUnsupported, DatabaseInUse, DatabaseTooNew) as error:
        raise CannotStart(str(error)) from error
    except OSError as error:
        raise CannotStart(
            f"the database's folder cannot be used ({error}); see CAMPUSLOOP_VAR_DIR"
        ) from error
    except SQLAlchemyError as error:
        cause = str(error).splitlines()[0]
        shown = open_engine(url).url.render_as_string(hide_password=True)
        raise CannotStart(
            f"the database {shown} cannot be used ({cause}); start it, or set CAMPUSLOOP_DATABASE_URL"
        ) from error
    return engine


async def _bus(settings: Settings) -> Bus:
    if not settings.bus_url:
        return InProcessBus()
    # Here, since the client and what it imports take 8 MB that a server without NATS does not need.
    from server.bus.nats import BusUnreachable, connect

    address = urlsplit(settings.bus_url)
    try:
        # The client itself would try for ever; at the start a missing server is an error.
        async with asyncio.timeout(BUS_TIMEOUT_S):
            _, probe = await asyncio.open_connection(address.hostname, address.port or NATS_PORT)
        probe.close()
        return await connect(settings.bus_url)
    except (OSError, TimeoutError, BusUnreachable) as error:
        raise CannotStart(
            f"no NATS server at {settings.bus_url} ({error}); start it, or leave CAMPUSLOOP_BUS_URL empty"
        ) from error


def fleet_rules(settings: Settings, road_map: RoadMap) -> FleetRules:
    """The fleet's rules, with the service hours of the settings. Raises CannotStart."""
    opens_s, closes_s = _second(settings.service_opens), _second(settings.service_closes)
    always = (opens_s, closes_s) == (0, DAY_S)
    if not 0 <= opens_s < closes_s <= DAY_S:
        raise CannotStart("service hours: CAMPUSLOOP_SERVICE_OPENS must lie before CAMPUSLOOP_SERVICE_CLOSES")
    openings = () if always else tuple(Opening(weekday, opens_s, closes_s) for weekday in range(7))
    hours = ServiceHours(road_map.timezone, openings)
    return FleetRules(
        hours=hours,
        operator_session_s=settings.session_hours * 3600.0,
        rider_days=settings.rider_days,
        audit_address_days=settings.audit_address_days,
        video_days=settings.video_days,
        scan_days=settings.scan_days,
        webhook_failure_days=settings.webhook_failure_days,
    )


def _second(clock_time: str) -> int:
    hours, minutes = clock_time.split(":")
    return int(hours) * 3600 + int(minutes) * 60


async def _prepare(transactions: Transactions, settings: Settings, road_map: RoadMap) -> str:
    password = settings.operator_password
    made = secrets.token_urlsafe(9)

    def work(uow: UnitOfWork) -> bool:
        campus.load_map_at_start(uow, encode_map(road_map))
        tickets.take_over_keys(uow)
        is_new = uow.identity.operator_by_name(settings.operator_name) is None
        if password or is_new:
            identity.set_password(uow, settings.operator_name, password or made)
        return is_new and not password

    return made if await transactions.run(work) else ""
