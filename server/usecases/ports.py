"""What the use cases need from outside: stores, a clock, ids. Filled in by `app.py`.

Repositories belong to one campus and one transaction. `get` answers None for what is not there; the use
cases turn that into the error with a name.
"""

from collections.abc import Callable, Sequence
from datetime import date, datetime
from typing import Protocol, TypeVar

from contract.roads.network import RoadNetwork
from contract.wire.messages import Status
from server.dispatch.problem import Problem
from server.dispatch.solve import Budget, Solution
from server.domain.closures import Closure
from server.domain.decisions import Decision, RideDecision
from server.domain.events import RecordedEvent, ServerEvent
from server.domain.identity import DeveloperToken, EnrolmentCode, Operator, OperatorSession, VehicleKey
from server.domain.incidents import Incident, IncidentKind
from server.domain.maps import ActiveMap, StoredMap
from server.domain.orders import IssuedOrder
from server.domain.pace import DrivenLeg, Paces
from server.domain.plans import Plan
from server.domain.rides import Ride, RideState, Tap
from server.domain.rules import FleetRules
from server.domain.runs import Run, Segment
from server.domain.sections import Occupancy
from server.domain.series import Occurrence, Series, SeriesState
from server.domain.service import ServiceException, ServicePattern
from server.domain.timetable import Departure
from server.domain.vehicles import StatusReport, Vehicle, VehicleCommand, Whereabouts
from server.usecases.fleet_roads import FleetRoads
from server.usecases.views import Views

T = TypeVar("T")


class Clock(Protocol):
    def now(self) -> datetime:
        """Aware UTC."""
        ...


class Ids(Protocol):
    """Names and secrets; seeded in virtual time."""

    def new_id(self, kind: str) -> str:
        """An id that no other thing has, e.g. new_id("ride")."""
        ...

    def ride_code(self) -> str:
        """Six characters that are not mistaken for one another when read aloud."""
        ...

    def boarding_code(self) -> str:
        """Four digits."""
        ...

    def token(self) -> str:
        """A secret of at least 128 bits, safe in a URL."""
        ...

    def seed(self) -> int:
        """For a random generator."""
        ...


class PasswordHasher(Protocol):
    def hash(self, password: str) -> str: ...

    def verify(self, password_hash: str, password: str) -> bool: ...


class MapLibrary(Protocol):
    """Decoded maps, each kept for the life of the process: a version never changes."""

    def known(self, map_version: str) -> FleetRoads | None: ...

    def decode(self, content: bytes) -> FleetRoads:
        """Raises MapInvalid."""
        ...


class Solver(Protocol):
    """`dispatch.solve` somewhere: inline, or in a child process."""

    async def solve(self, problem: Problem, budget: Budget, seed: int) -> Solution: ...


class Subscription(Protocol):
    """An asynchronous iterator of (topic, payload); the oldest are dropped for who cannot keep up."""

    def __aiter__(self) -> "Subscription": ...

    async def __anext__(self) -> tuple[str, bytes]: ...

    async def close(self) -> None: ...


class Bus(Protocol):
    """Disposable messages between replicas: whoever misses one reads the store."""

    async def publish(self, topic: str, payload: bytes) -> None: ...

    async def subscribe(self, pattern: str) -> Subscription:
        """pattern: topic levels divided by `/`, `*` for one level, `>` for the rest."""
        ...

    async def close(self) -> None: ...


# ---------------------------------------------------------------- repositories


class EventStore(Protocol):
    def count(self, vehicle_id: str, boot_id: str) -> int:
        """How many events of this boot are stored: the next sequence expected."""
        ...

    def add(self, event: RecordedEvent) -> None: ...


class EventRepository(EventStore, Protocol):
    def add_server_event(self, event: ServerEvent) -> None: ...


class RideRepository(Protocol):
    def get(self, ride_id: str) -> Ride | None: ...

    def by_code(self, ride_code: str) -> Ride | None:
        """The newest ride of this code that has not ended, else the newest."""
        ...

    def by_token(self, token: str) -> Ride | None: ...

    def by_idempotency_key(self, key: str) -> Ride | None: ...

    def in_states(self, states: Sequence[RideState]) -> tuple[Ride, ...]:
        """Oldest request first."""
        ...

    def of_vehicle(self, vehicle_id: str, states: Sequence[RideState]) -> tuple[Ride, ...]: ...

    def wanted_between(self, begins: datetime, ends: datetime) -> tuple[Ride, ...]:
        """Whatever has become of them: rides whose earliest pickup lies in [begins, ends); oldest request
        first."""
        ...

    def code_in_use(self, ride_code: str) -> bool: ...

    def add(self, ride: Ride) -> None: ...

    def save(self, ride: Ride) -> None: ...

    def add_tap(self, tap: Tap) -> None: ...

    def save_tap(self, tap: Tap) -> None: ...

    def tap(self, tap_id: str) -> Tap | None: ...

    def pending_taps(self, vehicle_id: str) -> tuple[Tap, ...]: ...


class PlanRepository(Protocol):
    def get(self, vehicle_id: str) -> Plan | None: ...

    def all(self) -> tuple[Plan, ...]:
        """By vehicle id."""
        ...

    def save(self, plan: Plan, expected_version: int) -> None:
        """Raises PlanChanged when the stored version is not expected_version (0: none stored yet)."""
        ...


class OrderRepository(Protocol):
    def current(self, vehicle_id: str) -> IssuedOrder | None:
        """The newest revision of the newest order."""
        ...

    def find(self, vehicle_id: str, order_id: str, revision: int) -> IssuedOrder | None: ...

    def add(self, order: IssuedOrder) -> None: ...

    def save(self, order: IssuedOrder) -> None: ...


class SectionRepository(Protocol):
    def all(self) -> tuple[Occupancy, ...]:
        """Every vehicle on the road, by vehicle id."""
        ...

    def save(self, occupancy: Occupancy) -> None: ...

    def remove(self, vehicle_id: str) -> None: ...

    def next_fence(self) -> int:
        """Higher than any fence given before on this campus."""
        ...


class VehicleRepository(Protocol):
    def get(self, vehicle_id: str) -> Vehicle | None: ...

    def all(self) -> tuple[Vehicle, ...]:
        """By vehicle id, retired ones left out."""
        ...

    def add(self, vehicle: Vehicle) -> None: ...

    def save(self, vehicle: Vehicle) -> None: ...

    def whereabouts(self, vehicle_id: str) -> Whereabouts | None: ...

    def all_whereabouts(self) -> tuple[Whereabouts, ...]: ...

    def heard(self, vehicle_id: str, at: datetime) -> None: ...

    def save_position(self, vehicle_id: str, status: Status) -> None:
        """A better word on where it is than its newest report; no history."""
        ...

    def save_status(self, reports: Sequence[StatusReport]) -> None:
        """The newest of each vehicle becomes its whereabouts; all of them become history."""
        ...

    def add_command(self, command: VehicleCommand) -> None: ...

    def save_command(self, command: VehicleCommand) -> None: ...

    def command(self, command_id: str) -> VehicleCommand | None: ...

    def pending_commands(self, vehicle_id: str) -> tuple[VehicleCommand, ...]:
        """Oldest first."""
        ...


class DepartureRepository(Protocol):
    def get(self, departure_id: str) -> Departure | None: ...

    def unfinished(self) -> tuple[Departure, ...]:
        """Planned or assigned, by first call."""
        ...

    def add(self, departure: Departure) -> None: ...

    def save(self, departure: Departure) -> None: ...


class ServiceRepository(Protocol):
    def patterns(self) -> tuple[ServicePattern, ...]:
        """By service id."""
        ...

    def pattern(self, service_id: str) -> ServicePattern | None: ...

    def save_pattern(self, pattern: ServicePattern) -> None:
        """New, or in place of the one of this service."""
        ...

    def remove_pattern(self, service_id: str) -> None:
        """With its exceptions."""
        ...

    def exceptions(self, since: date | None = None) -> tuple[ServiceException, ...]:
        """By day, the whole campus's before single services'."""
        ...

    def save_exception(self, exception: ServiceException) -> None: ...

    def remove_exception(self, day: date, service_id: str) -> bool:
        """False when there was none."""
        ...


class ClosureRepository(Protocol):
    def get(self, closure_id: str) -> Closure | None: ...

    def standing(self) -> tuple[Closure, ...]:
        """Scheduled or in force, by beginning."""
        ...

    def add(self, closure: Closure) -> None: ...

    def save(self, closure: Closure) -> None: ...


class PaceRepository(Protocol):
    def begin_leg(self, vehicle_id: str, from_stop: str, left_at: datetime) -> None: ...

    def end_leg(self, vehicle_id: str) -> tuple[str, datetime] | None:
        """Where and when the leg under way began, None for none; there is none any more."""
        ...

    def add(self, leg: DrivenLeg) -> None: ...

    def legs(self) -> tuple[DrivenLeg, ...]:
        """Oldest first."""
        ...

    def forget_before(self, moment: datetime) -> int: ...

    def present(self) -> Paces | None: ...

    def save(self, paces: Paces) -> None: ...


class SeriesRepository(Protocol):
    def get(self, series_id: str) -> Series | None: ...

    def by_token(self, token: str) -> Series | None: ...

    def by_idempotency_key(self, key: str) -> Series | None: ...

    def listed(
        self, states: Sequence[SeriesState] | None = None, limit: int | None = None
    ) -> tuple[Series, ...]:
        """Newest first."""
        ...

    def add(self, series: Series) -> None: ...

    def save(self, series: Series) -> None: ...

    def occurrence(self, series_id: str, day: date) -> Occurrence | None: ...

    def occurrences(self, series_id: str) -> tuple[Occurrence, ...]:
        """Those that something has happened to, by day."""
        ...

    def occurrences_between(self, first: date, last: date) -> tuple[Occurrence, ...]:
        """Everybody's on these days, both included."""
        ...

    def save_occurrence(self, occurrence: Occurrence) -> None: ...


class IncidentRepository(Protocol):
    def get(self, incident_id: str) -> Incident | None: ...

    def open_about(self, kind: IncidentKind, subject: str) -> Incident | None: ...

    def all_open(self) -> tuple[Incident, ...]:
        """Most urgent first, then oldest."""
        ...

    def add(self, incident: Incident) -> None: ...

    def save(self, incident: Incident) -> None: ...


class MapRepository(Protocol):
    def get(self, map_version: str) -> StoredMap | None: ...

    def active_version(self) -> str | None: ...

    def active(self) -> ActiveMap: ...

    def add(self, stored: StoredMap) -> None: ...

    def activate(self, map_version: str) -> None: ...


class RunRepository(Protocol):
    def get(self, vehicle_id: str, boot_id: str) -> Run | None: ...

    def add(self, run: Run) -> None: ...

    def segment(self, sha256: str) -> Segment | None: ...

    def add_segment(self, segment: Segment) -> None: ...


class IdentityRepository(Protocol):
    def operator(self, operator_id: str) -> Operator | None: ...

    def operator_by_name(self, name: str) -> Operator | None: ...

    def save_operator(self, operator: Operator) -> None: ...

    def operator_session(self, token_sha256: str) -> OperatorSession | None: ...

    def add_operator_session(self, session: OperatorSession) -> None: ...

    def remove_operator_session(self, token_sha256: str) -> None: ...

    def forget_sessions_before(self, moment: datetime) -> int:
        """How many expired sessions were dropped."""
        ...

    def vehicle_key(self, vehicle_id: str) -> VehicleKey | None: ...

    def save_vehicle_key(self, key: VehicleKey) -> None: ...

    def enrolment_code(self, code_sha256: str) -> EnrolmentCode | None: ...

    def save_enrolment_code(self, code: EnrolmentCode) -> None: ...

    def developer_token(self, token_sha256: str) -> DeveloperToken | None: ...

    def developer_token_by_id(self, token_id: str) -> DeveloperToken | None: ...

    def developer_tokens(self) -> tuple[DeveloperToken, ...]: ...

    def save_developer_token(self, token: DeveloperToken) -> None: ...


class LeaseRepository(Protocol):
    def take(self, name: str, holder: str, now: datetime, seconds: float) -> int | None:
        """A fencing token, higher for every new holder; None while another one holds the lease."""
        ...

    def token(self, name: str) -> int:
        """The fencing token of the lease's present or last holder, 0 when it was never held."""
        ...


class DecisionRepository(Protocol):
    def add(self, decision: Decision) -> None: ...

    def add_rides(self, decided: list[RideDecision]) -> None: ...

    def of_ride(self, ride_id: str) -> tuple[RideDecision, ...]:
        """Oldest first."""
        ...

    def get(self, decision_id: str) -> Decision | None: ...

    def between(self, begins: datetime, ends: datetime) -> tuple[Decision, ...]:
        """In the order in which they were made."""
        ...

    def forget_before(self, oldest: datetime) -> int: ...


class HistoryRepository(Protocol):
    def forget_before(self, moment: datetime) -> int:
        """How many positions were dropped."""
        ...


# ---------------------------------------------------------------- one transaction


class UnitOfWork(Protocol):
    """One transaction on one campus. Nobody commits: returning does, raising does not."""

    campus_id: str
    now: datetime
    rules: FleetRules
    ids: Ids
    hasher: PasswordHasher
    rides: RideRepository
    plans: PlanRepository
    orders: OrderRepository
    sections: SectionRepository
    vehicles: VehicleRepository
    departures: DepartureRepository
    decisions: DecisionRepository
    service: ServiceRepository
    closures: ClosureRepository
    paces: PaceRepository
    series: SeriesRepository
    incidents: IncidentRepository
    events: EventRepository
    maps: MapRepository
    runs: RunRepository
    identity: IdentityRepository
    leases: LeaseRepository
    history: HistoryRepository

    @property
    def views(self) -> Views:
        """What pages show, with all that this transaction has changed."""
        ...

    def network(self) -> RoadNetwork:
        """The active map, decoded. Raises CampusUnknown."""
        ...

    def roads(self) -> FleetRoads:
        """The active map as the fleet uses it, without the roads closed now. Raises CampusUnknown."""
        ...

    def has_closures(self) -> bool:
        """Some road closure is scheduled or in force; asks nothing that `roads` has not asked."""
        ...

    def hour_of(self, moment: datetime) -> float:
        """The time of day on the campus, in hours after local midnight. Raises CampusUnknown."""
        ...

    def pace_at(self, moment: datetime) -> float:
        """What driving takes at this time of day, over the map's times; 1 before anything is learnt.
        Raises CampusUnknown."""
        ...

    def network_of(self, content: bytes) -> RoadNetwork:
        """The map in these bytes, decoded and kept. Raises MapInvalid."""
        ...

    def network_at(self, map_version: str) -> RoadNetwork | None:
        """A stored map, active or not, decoded once; None for one that is not stored."""
        ...

    def roads_changed(self) -> None:
        """Another map is active now, or a road was closed or opened: `roads` has to look again."""
        ...

    def publish(self, topic: str, **fields: str | int) -> None:
        """Say on the bus, after the commit, that something has changed."""
        ...


class Transactions(Protocol):
    """Runs a use case whole: `await transactions.run(lambda uow: rides.book(uow, request))`."""

    async def run(self, work: Callable[[UnitOfWork], T]) -> T:
        """Commit on return, roll back on any exception, repeat on PlanChanged; then publish."""
        ...

    async def read(self, work: Callable[[UnitOfWork], T]) -> T:
        """Run something that only reads, without waiting for writers."""
        ...
