"""One transaction on one campus, with every repository on its connection."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from zoneinfo import ZoneInfo

import msgspec
from sqlalchemy import Connection

from contract.roads.network import RoadNetwork
from server.domain.errors import CampusUnknown
from server.domain.planning.travel_time_factors import travel_time_factor_at
from server.domain.rides.ticket_keys import TicketKeys
from server.domain.rules import FleetRules
from server.store.cache.events import CachedEventRepository
from server.store.cache.ground import (
    CachedClosureRepository,
    CachedLocalizationMapRepository,
    CachedMapRepository,
    CachedTravelTimeFactorRepository,
)
from server.store.cache.incidents import CachedIncidentRepository
from server.store.cache.memory import RowCache
from server.store.cache.orders import CachedOrderRepository
from server.store.cache.plans import CachedPlanRepository
from server.store.cache.rides import CachedRideRepository
from server.store.cache.sections import CachedSectionRepository
from server.store.cache.service import CachedServiceRepository
from server.store.cache.vehicles import CachedVehicleRepository
from server.store.fleet.history import SqlHistoryRepository
from server.store.fleet.scans import SqlScanRepository
from server.store.fleet.vehicles import SqlVehicleRepository
from server.store.fleet.videos import SqlVideoRepository
from server.store.leases import SqlLeaseRepository
from server.store.orders.orders import SqlOrderRepository
from server.store.orders.sections import SqlSectionRepository
from server.store.past import SqlPast
from server.store.planning.decisions import SqlDecisionRepository
from server.store.planning.departures import SqlDepartureRepository
from server.store.planning.plans import SqlPlanRepository
from server.store.planning.travel_time_factors import SqlTravelTimeFactorRepository
from server.store.record.announcements import SqlAnnouncementRepository
from server.store.record.answers import SqlAnswerRepository
from server.store.record.audit import SqlAuditRepository
from server.store.record.events import SqlEventRepository
from server.store.record.identity import SqlIdentityRepository
from server.store.record.incidents import SqlIncidentRepository
from server.store.record.recordings import SqlRecordingRepository
from server.store.record.runs import SqlRunRepository
from server.store.record.second_factors import SqlSecondFactorRepository
from server.store.record.service import SqlServiceRepository
from server.store.record.webhooks import SqlWebhookRepository
from server.store.rides.push_subscriptions import SqlPushSubscriptionRepository
from server.store.rides.rides import SqlRideRepository
from server.store.rides.series import SqlSeriesRepository
from server.store.roads.closures import SqlClosureRepository
from server.store.roads.localization_maps import SqlLocalizationMapRepository
from server.store.roads.map_drafts import SqlMapDraftRepository
from server.store.roads.maps import SqlMapRepository
from server.store.views import SqlViews
from server.store.writing.campus_lock import CampusLock
from server.travel.closed_roads import sections_closed
from server.travel.fleet_roads import FleetRoads
from server.usecases.ports.clock_and_ids import Clock, Ids, PasswordHasher
from server.usecases.ports.maps import (
    ClosureRepository,
    LocalizationMapRepository,
    MapDraftRepository,
    MapLibrary,
    MapRepository,
)
from server.usecases.ports.past import Past
from server.usecases.ports.plans import (
    OrderRepository,
    PlanRepository,
    SectionRepository,
    TravelTimeFactorRepository,
)
from server.usecases.ports.records import (
    AnnouncementRepository,
    AnswerRepository,
    AuditRepository,
    IdentityRepository,
    IncidentRepository,
    LeaseRepository,
    RecordingRepository,
    RunRepository,
    SecondFactorRepository,
    WebhookRepository,
)
from server.usecases.ports.rides import (
    DecisionRepository,
    PushSubscriptionRepository,
    RideRepository,
    SeriesRepository,
)
from server.usecases.ports.scans import ScanRepository
from server.usecases.ports.service import DepartureRepository, ServiceRepository
from server.usecases.ports.vehicles import EventRepository, HistoryRepository, VehicleRepository
from server.usecases.ports.videos import VideoRepository
from server.usecases.ports.views import Views


@dataclass(frozen=True, slots=True)
class Context:
    """What every transaction of one campus needs."""

    campus_id: str
    clock: Clock
    ids: Ids
    rules: FleetRules
    hasher: PasswordHasher
    library: MapLibrary
    tickets: TicketKeys


@dataclass(frozen=True, slots=True)
class PublishedMessage:
    """A message that goes out when the transaction has been committed."""

    topic: str
    payload: bytes


PublishedMessages = tuple[PublishedMessage, ...]


@dataclass(slots=True)
class OutgoingMessages:
    """The messages of a transaction, each one once, in the order in which they were first published."""

    messages: dict[tuple[str, bytes], PublishedMessage] = field(default_factory=dict)

    def add(self, topic: str, fields: Mapping[str, str | int]) -> None:
        payload = msgspec.json.encode(dict(sorted(fields.items())))
        self.messages.setdefault((topic, payload), PublishedMessage(topic, payload))


class SqlUnitOfWork:
    """See `server.usecases.ports.unit_of_work.UnitOfWork`.

    lock, memory  of a transaction that writes: its campus's lock, and what its writer keeps of the live fleet
    """

    def __init__(
        self,
        connection: Connection,
        context: Context,
        *,
        lock: CampusLock | None = None,
        memory: RowCache | None = None,
    ) -> None:
        campus_id = context.campus_id
        self.campus_id = campus_id
        self.now: datetime = context.clock.now()
        self.rules = context.rules
        self.ids = context.ids
        self.hasher = context.hasher
        self.tickets = context.tickets
        self.outgoing = OutgoingMessages()
        if lock is None or memory is None:
            self._rides = SqlRideRepository(connection, campus_id, lock)
            self._events = SqlEventRepository(connection, campus_id, lock)
            self.plans: PlanRepository = SqlPlanRepository(connection, campus_id, lock)
            self.orders: OrderRepository = SqlOrderRepository(connection, campus_id, lock)
            self._sections = SqlSectionRepository(connection, campus_id, lock)
            self._vehicles = SqlVehicleRepository(connection, campus_id, lock)
            self.service: ServiceRepository = SqlServiceRepository(connection, campus_id, lock)
            self.incidents: IncidentRepository = SqlIncidentRepository(connection, campus_id, lock)
            self.maps: MapRepository = SqlMapRepository(connection, campus_id, lock)
            self.localization_maps: LocalizationMapRepository = SqlLocalizationMapRepository(
                connection, campus_id, lock
            )
            self.closures: ClosureRepository = SqlClosureRepository(connection, campus_id, lock)
            self.travel_time_factors: TravelTimeFactorRepository = SqlTravelTimeFactorRepository(
                connection, campus_id, lock
            )
        else:
            self._rides = CachedRideRepository(connection, campus_id, lock, memory)
            self.plans = CachedPlanRepository(connection, campus_id, lock, memory)
            self.orders = CachedOrderRepository(connection, campus_id, lock, memory)
            self._sections = CachedSectionRepository(connection, campus_id, lock, memory)
            self._vehicles = CachedVehicleRepository(connection, campus_id, lock, memory)
            self.service = CachedServiceRepository(connection, campus_id, lock, memory)
            self.incidents = CachedIncidentRepository(connection, campus_id, lock, memory)
            self.maps = CachedMapRepository(connection, campus_id, lock, memory)
            self.localization_maps = CachedLocalizationMapRepository(connection, campus_id, lock, memory)
            self.closures = CachedClosureRepository(connection, campus_id, lock, memory)
            self.travel_time_factors = CachedTravelTimeFactorRepository(connection, campus_id, lock, memory)
            self._events = CachedEventRepository(connection, campus_id, lock, memory)
        self.rides: RideRepository = self._rides
        self.vehicles: VehicleRepository = self._vehicles
        self.sections: SectionRepository = self._sections
        self.map_drafts: MapDraftRepository = SqlMapDraftRepository(connection, campus_id, lock)
        self.departures: DepartureRepository = SqlDepartureRepository(connection, campus_id, lock)
        self.decisions: DecisionRepository = SqlDecisionRepository(connection, campus_id, lock)
        self.series: SeriesRepository = SqlSeriesRepository(connection, campus_id, lock)
        self.push_subscriptions: PushSubscriptionRepository = SqlPushSubscriptionRepository(
            connection, campus_id, lock
        )
        self.events: EventRepository = self._events
        self.announcements: AnnouncementRepository = SqlAnnouncementRepository(connection, campus_id, lock)
        self.runs: RunRepository = SqlRunRepository(connection, campus_id, lock)
        self.scans: ScanRepository = SqlScanRepository(connection, campus_id, lock)
        self.videos: VideoRepository = SqlVideoRepository(connection, campus_id, lock)
        self.recordings: RecordingRepository = SqlRecordingRepository(connection, campus_id, lock)
        self.identity: IdentityRepository = SqlIdentityRepository(connection, campus_id, lock)
        self.second_factors: SecondFactorRepository = SqlSecondFactorRepository(connection, campus_id, lock)
        self.audit: AuditRepository = SqlAuditRepository(connection, campus_id, lock)
        self.answers: AnswerRepository = SqlAnswerRepository(connection, campus_id, lock)
        self.leases: LeaseRepository = SqlLeaseRepository(connection, campus_id, lock)
        self.webhooks: WebhookRepository = SqlWebhookRepository(connection, campus_id, lock)
        self.history: HistoryRepository = SqlHistoryRepository(connection, campus_id, lock)
        self._views = SqlViews(connection, campus_id, lock)
        self._past = SqlPast(connection, campus_id, lock)
        self._library = context.library
        self._roads: FleetRoads | None = None
        self._has_closures = False
        self._factors: tuple[float, ...] | None = None

    @property
    def views(self) -> Views:
        self.flush()
        return self._views

    @property
    def past(self) -> Past:
        self.flush()
        return self._past

    def flush(self) -> None:
        """Write what waits for the end of the transaction."""
        self._rides.flush()
        self._events.flush()
        self._sections.flush()
        self._vehicles.flush()

    def network(self) -> RoadNetwork:
        return self.roads().network

    def roads(self) -> FleetRoads:
        if self._roads is None:
            self._roads = self._active_roads()
        return self._roads

    def has_closures(self) -> bool:
        self.roads()
        return self._has_closures

    def hour_of(self, moment: datetime) -> float:
        local = moment.astimezone(ZoneInfo(self.network().road_map.timezone))
        return local.hour + local.minute / 60.0 + local.second / 3600.0

    def travel_time_factor_at(self, moment: datetime) -> float:
        self.roads()
        return 1.0 if self._factors is None else travel_time_factor_at(self._factors, self.hour_of(moment))

    def network_at(self, map_version: str) -> RoadNetwork | None:
        roads = self.roads_at(map_version)
        return None if roads is None else roads.network

    def publish(self, topic: str, **fields: str | int) -> None:
        self.outgoing.add(topic, fields)

    def roads_changed(self) -> None:
        self._roads = None

    def _active_roads(self) -> FleetRoads:
        active = self.maps.active()
        version, self._has_closures, self._factors = active.map_version, active.has_closures, active.factors
        if version is None:
            raise CampusUnknown(f"campus {self.campus_id} has no map; import one and activate it")
        roads = self.roads_at(version)
        if roads is None:
            raise CampusUnknown(f"the active map {version} is missing from the store; import it again")
        if not self._has_closures:
            return roads
        return roads.closed_to(sections_closed(self.closures.standing(), roads.network))

    def roads_at(self, map_version: str) -> FleetRoads | None:
        """Decoded once for the life of the process; None for a map that is not stored."""
        known = self._library.known(map_version)
        if known is not None:
            return known
        stored = self.maps.get(map_version)
        return None if stored is None else self._library.decode(stored.content)
