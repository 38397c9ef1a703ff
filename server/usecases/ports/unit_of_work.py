"""One transaction on one campus, and what runs it.

Repositories belong to one campus and one transaction. `get` answers None for what is not there; the use
cases turn that into the error with a name.
"""

from collections.abc import Callable
from datetime import datetime
from typing import Protocol, TypeVar

from contract.roads.network import RoadNetwork
from server.domain.rides.ticket_keys import TicketKeys
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads
from server.usecases.ports.clock_and_ids import Ids, PasswordHasher
from server.usecases.ports.maps import (
    ClosureRepository,
    LocalizationMapRepository,
    MapDraftRepository,
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

T = TypeVar("T")


class UnitOfWork(Protocol):
    """One transaction on one campus. Returning commits it, raising rolls it back."""

    campus_id: str
    now: datetime
    rules: FleetRules
    ids: Ids
    hasher: PasswordHasher
    tickets: TicketKeys
    rides: RideRepository
    plans: PlanRepository
    orders: OrderRepository
    sections: SectionRepository
    vehicles: VehicleRepository
    departures: DepartureRepository
    decisions: DecisionRepository
    service: ServiceRepository
    closures: ClosureRepository
    announcements: AnnouncementRepository
    travel_time_factors: TravelTimeFactorRepository
    series: SeriesRepository
    push_subscriptions: PushSubscriptionRepository
    incidents: IncidentRepository
    events: EventRepository
    maps: MapRepository
    map_drafts: MapDraftRepository
    localization_maps: LocalizationMapRepository
    runs: RunRepository
    recordings: RecordingRepository
    scans: ScanRepository
    videos: VideoRepository
    identity: IdentityRepository
    second_factors: SecondFactorRepository
    audit: AuditRepository
    answers: AnswerRepository
    leases: LeaseRepository
    webhooks: WebhookRepository
    history: HistoryRepository

    @property
    def views(self) -> Views:
        """Reads for pages, with all changes of this transaction."""
        ...

    @property
    def past(self) -> Past:
        """What is stored of a stretch of time."""
        ...

    def network(self) -> RoadNetwork:
        """The active map, decoded. Raises CampusUnknown."""
        ...

    def roads(self) -> FleetRoads:
        """The active map as the fleet uses it, without the roads closed now. Raises CampusUnknown."""
        ...

    def has_closures(self) -> bool:
        """Some road closure is scheduled or in force. It needs no query beyond that of `roads`."""
        ...

    def hour_of(self, moment: datetime) -> float:
        """The time of day on the campus, in hours after local midnight. Raises CampusUnknown."""
        ...

    def travel_time_factor_at(self, moment: datetime) -> float:
        """What driving takes at this time of day, over the map's times; 1 before anything is learnt.
        Raises CampusUnknown."""
        ...

    def network_at(self, map_version: str) -> RoadNetwork | None:
        """A stored map, active or not, decoded once; None for one that is not stored."""
        ...

    def roads_at(self, map_version: str) -> FleetRoads | None:
        """A stored map as the fleet uses it, active or not, all its roads open; None as in `network_at`.
        Raises MapInvalid."""
        ...

    def roads_changed(self) -> None:
        """Another map is active now, or a road was closed or opened: `roads` must read again."""
        ...

    def publish(self, topic: str, **fields: str | int) -> None:
        """Publish on the bus, after the commit, that something has changed."""
        ...


class Transactions(Protocol):
    """Runs a use case whole: `await transactions.run(lambda uow: rides.book(uow, request))`."""

    async def run(self, work: Callable[[UnitOfWork], T]) -> T:
        """Commit on return, roll back on any exception, repeat on PlanChanged; then publish.

        Raises what `work` raises; StoreUnavailable (nothing is stored) and OutcomeUnknown (it may be stored).
        """
        ...

    async def read(self, work: Callable[[UnitOfWork], T]) -> T:
        """Run something that only reads, without waiting for writers. Raises StoreUnavailable."""
        ...
