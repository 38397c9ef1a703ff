"""Keeps the scene board up to date: positions come by the bus, everything else is read from the store.

A message on the bus only says what to read again. The whole board is read again every READ_ALL_EVERY_S, so a
lost message only makes it stale for some seconds. While nobody watches nothing is read; the first who comes
waits for a whole reading.
"""

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

import msgspec

from contract.roads.network import RoadNetwork
from contract.wire.messages import Status
from server.domain.instants import ms_of
from server.domain.planning.outlooks import RideOutlook
from server.domain.record.incidents import Incident
from server.domain.rides.rides import ENDED, Ride, RideState
from server.domain.rules import FleetRules
from server.live.projection import incidents_scene, ride_scene, vehicle_scene, with_status
from server.live.route_shape import RouteShapes
from server.live.scene import AreaScene, SceneBoard, VehicleScene
from server.live.shared_text import SharedText
from server.supervision.standing_tasks import PeriodicTask, StandingTask, TopicReader
from server.supervision.supervisor import Supervisor
from server.usecases.planning.outlooks import outlooks_of
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.ports.views import VehicleView

READ_ALL_EVERY_S = 10.0
RIDES_MAX = 500
# An ended ride stays on screens for as long as its passenger's page may show the result.
LINGER_MS = 120_000
ACTIVE = tuple(state for state in RideState if state not in ENDED)


@dataclass(slots=True)
class _Stale:
    """What has to be read again; rides and vehicles by id."""

    everything: bool = False
    incidents: bool = False
    rides: set[str] = field(default_factory=set)
    vehicles: set[str] = field(default_factory=set)

    def __bool__(self) -> bool:
        return self.everything or self.incidents or bool(self.rides or self.vehicles)


@dataclass(frozen=True, slots=True)
class _Reading:
    """The result of one read transaction; incidents: None if they were not read. outlooks: by ride id."""

    network: RoadNetwork | None
    vehicles: tuple[VehicleView, ...]
    rides: tuple[Ride, ...]
    outlooks: Mapping[str, RideOutlook]
    incidents: tuple[Incident, ...] | None
    rules: FleetRules


class _PresenceFields(msgspec.Struct, frozen=True):
    """The fields of a camera's report that are shown."""

    area_id: str
    count: int
    stamp_ns: int


class SceneFeed:
    """Call `start`; then viewers read the board of `watched`; then `close`."""

    def __init__(
        self,
        campus_id: str,
        clock: Clock,
        transactions: Transactions,
        bus: Bus,
        supervisor: Supervisor,
        interval_s: float = 0.2,
    ) -> None:
        self.board = SceneBoard(campus_id)
        self.text = SharedText()
        self._clock, self._transactions, self._bus = clock, transactions, bus
        self._supervisor = supervisor
        self._interval_s = interval_s
        self._read_all_at_ms = 0
        self._stale = _Stale(everything=True)
        self._watchers = 0
        self._reading = asyncio.Lock()
        self._incident_changes = 0
        self._shapes: RouteShapes | None = None
        self._chargers: frozenset[str] = frozenset()
        self._standing: list[asyncio.Task[None]] = []
        self._news = asyncio.Event()

    async def start(self) -> None:
        readers = [
            TopicReader(f"feed.{name}", self._bus, topic, self._take)
            for name, topic in _topics_shown(self.board.campus_id)
        ]
        for reader in readers:
            await reader.subscribe()
        refresh = PeriodicTask("feed.refresh", self._refresh, self._interval_s)
        standing: list[StandingTask] = [*readers, refresh]
        self._standing = [self._supervisor.start(task) for task in standing]

    async def close(self) -> None:
        for task in self._standing:
            task.cancel()
        if self._standing:
            await asyncio.wait(self._standing)

    @asynccontextmanager
    async def watched(self) -> AsyncIterator[SceneBoard]:
        """The board, complete at the beginning and kept up to date while this lasts. Raises StoreFailure."""
        self._watchers += 1
        try:
            if self._stale.everything or self._reading.locked():
                await self._refresh()
            yield self.board
        finally:
            self._watchers -= 1

    @property
    def news(self) -> asyncio.Event:
        """Set when something has happened that an operator should see before the next regular message: a
        vehicle stops, holds or opens its doors, a ride or an incident changes. Each is another event."""
        return self._news

    # ---------------------------------------------------------------- inside

    def _tell(self) -> None:
        self._news.set()
        self._news = asyncio.Event()

    def _take(self, topic: str, payload: bytes) -> None:
        match topic.split("/")[2:]:
            case ["vehicle", vehicle_id, "live"]:
                self._put_status(vehicle_id, payload)
            case ["vehicle", vehicle_id, "state" | "session" | "outbox"]:
                self._stale.vehicles.add(vehicle_id)
            case ["ride", ride_id]:
                self._stale.rides.add(ride_id)
            case ["area", _, "presence"]:
                self._put_presence(payload)
            case ["incidents"]:
                self._incident_changes += 1
                self._stale.incidents = True
            case ["map"]:
                self._stale.everything = True

    def _put_status(self, vehicle_id: str, payload: bytes) -> None:
        scene = self.board.vehicle(vehicle_id)
        if scene is None:
            self._stale.vehicles.add(vehicle_id)
            return
        status = msgspec.json.decode(payload, type=Status)
        # Its visit or its riders have changed, and with them the route ahead.
        known = scene.status
        if known is None or (status.visit_id, status.aboard) != (known.visit_id, known.aboard):
            self._stale.vehicles.add(vehicle_id)
        self.board.put_vehicle(with_status(scene, status, ms_of(self._clock.now())))
        if known is None or _conduct(status) != _conduct(known):
            self._tell()

    def _put_presence(self, payload: bytes) -> None:
        report = msgspec.json.decode(payload, type=_PresenceFields)
        self.board.put_area(AreaScene(report.area_id, report.count, report.stamp_ns // 1_000_000))

    async def _refresh(self) -> None:
        """Read again what is stale, if anybody watches. After a reading that failed everything is."""
        async with self._reading:
            if not self._watchers:
                self._stale = _Stale(everything=True)
                return
            now_ms = ms_of(self._clock.now())
            if now_ms - self._read_all_at_ms >= READ_ALL_EVERY_S * 1000.0:
                self._stale.everything = True
            if not self._stale:
                return
            stale, self._stale = self._stale, _Stale()
            if stale.everything:
                self._read_all_at_ms = now_ms
            try:
                await self._read(stale)
            except (Exception, asyncio.CancelledError):
                # Cancelled: the viewer that waited for it has gone.
                self._stale.everything = True
                raise

    async def _read(self, stale: _Stale) -> None:
        shown_before = frozenset(self.board.rides)
        reading = await self._transactions.read(lambda uow: _reading(uow, stale, shown_before))
        board, now_ms = self.board, ms_of(self._clock.now())
        self._show_map(reading.network)
        if reading.incidents is not None:
            board.incidents = incidents_scene(reading.incidents, self._incident_changes)
        shown = {ride.ride_id: ride for ride in reading.rides if _is_shown(ride, now_ms)}
        for ride in shown.values():
            board.put_ride(ride_scene(ride, outlook=reading.outlooks[ride.ride_id]))
        for ride_id in set(board.rides if stale.everything else stale.rides) - shown.keys():
            board.remove_ride(ride_id)
        parties = {ride_id: scene.party for ride_id, (_, scene) in board.rides.items()}
        for view in reading.vehicles:
            self._put(view, parties, reading.rules)
        present = {view.vehicle.vehicle_id for view in reading.vehicles}
        for vehicle_id in set(board.vehicles if stale.everything else stale.vehicles) - present:
            board.remove_vehicle(vehicle_id)
        if stale.incidents or stale.rides or stale.vehicles:
            self._tell()

    def _show_map(self, network: RoadNetwork | None) -> None:
        self.board.map_version = "" if network is None else network.map_version
        places = () if network is None else network.road_map.charging_places
        self._chargers = frozenset(place.place_id for place in places)
        if network is None:
            self._shapes = None
        elif self._shapes is None or self._shapes.lines is not network.lines:
            self._shapes = RouteShapes(network.lines)

    def _put(self, view: VehicleView, parties: Mapping[str, int], rules: FleetRules) -> None:
        scene = vehicle_scene(view, self._shapes, parties, rules, self._chargers)
        held = self.board.vehicle(scene.vehicle_id)
        if held is not None and held.status is not None:
            scene = _with_newer_status(scene, held, held.status)
        self.board.put_vehicle(scene)


def _conduct(status: Status) -> tuple[object, ...]:
    """What a vehicle does, without where it is."""
    return status.mode, status.doors_open, status.hold_reason, status.faults


def _topics_shown(campus_id: str) -> tuple[tuple[str, str], ...]:
    """What may change the board. Events of vehicles, the most frequent topic, do not by themselves."""
    return (
        ("positions", topics.vehicle_live(campus_id, "*")),
        ("vehicles", topics.vehicle(campus_id, "*")),
        ("sessions", topics.vehicle_session(campus_id, "*")),
        ("outbox", topics.vehicle_outbox(campus_id, "*")),
        ("rides", topics.ride(campus_id, "*")),
        ("presence", topics.area_presence(campus_id, "*")),
        ("incidents", topics.incidents(campus_id)),
        ("map", topics.campus_map(campus_id)),
    )


def _with_newer_status(scene: VehicleScene, held: VehicleScene, status: Status) -> VehicleScene:
    """The store's vehicle with the bus's newer status, because the store lags and has no `driving`."""
    if held.heard_ms <= scene.heard_ms and scene.status is not None:
        status = msgspec.structs.replace(scene.status, driving=status.driving)
        return msgspec.structs.replace(scene, status=status)
    return msgspec.structs.replace(scene, status=status, heard_ms=held.heard_ms)


def _reading(uow: UnitOfWork, stale: _Stale, shown: frozenset[str]) -> _Reading:
    """shown: the rides on the board. An empty board also gets the last that ended."""
    network = uow.network() if uow.maps.active_version() is not None else None
    views = uow.views
    incidents = views.incidents(limit=RIDES_MAX) if stale.everything or stale.incidents else None
    if stale.everything:
        found = {ride.ride_id: ride for ride in views.rides(states=ACTIVE, limit=RIDES_MAX)}
        ended = shown - found.keys()
        if ended:
            found |= {ride.ride_id: ride for ride in views.rides(ride_ids=ended, limit=len(ended))}
        elif not shown:
            found |= {ride.ride_id: ride for ride in views.rides(limit=RIDES_MAX)}
        shown_rides = tuple(found.values())
        outlooks = outlooks_of(uow, shown_rides)
        return _Reading(network, views.vehicles(), shown_rides, outlooks, incidents, uow.rules)
    rides = views.rides(ride_ids=stale.rides, limit=len(stale.rides)) if stale.rides else ()
    vehicles = views.vehicles(stale.vehicles) if stale.vehicles else ()
    return _Reading(network, vehicles, rides, outlooks_of(uow, rides), incidents, uow.rules)


def _is_shown(ride: Ride, now_ms: int) -> bool:
    return ride.ended_at is None or now_ms - ms_of(ride.ended_at) < LINGER_MS
