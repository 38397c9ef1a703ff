"""Reads for pages, taken from the store without the rules of the domain."""

from collections.abc import Sequence, Set
from dataclasses import dataclass
from datetime import datetime
from typing import Protocol

from contract.wire.messages import Status
from server.domain.fleet.battery import charged_at
from server.domain.fleet.vehicles import Vehicle, VehicleCommand
from server.domain.orders.orders import OrderState
from server.domain.orders.sections import HeldSection
from server.domain.planning.plans import Plan
from server.domain.record.events import RecordedEvent, ServerEvent
from server.domain.record.incidents import Incident
from server.domain.record.runs import Run
from server.domain.rides.rides import Ride, RideState
from server.domain.rules import FleetRules
from server.domain.service.timetable import Departure


@dataclass(frozen=True, slots=True)
class VehicleView:
    """A vehicle with everything a console shows of it.

    order_waits   the plan is newer than the order: its route is not safe yet
    route         lanes of the order in force, from where it was made to the resting place, no lane doubled
    """

    vehicle: Vehicle
    plan: Plan
    held_sections: tuple[HeldSection, ...]
    sections_ahead: tuple[str, ...]
    heard_at: datetime | None = None
    status: Status | None = None
    order_id: str = ""
    revision: int = 0
    order_state: OrderState | None = None
    order_waits: bool = False
    route: tuple[str, ...] = ()
    last_command: VehicleCommand | None = None

    def charged_at(self, rules: FleetRules) -> datetime | None:
        """When it will have charged, if it is at a charger by now; None when it does not charge."""
        if not self.vehicle.charging or self.status is None or self.heard_at is None:
            return None
        return charged_at(self.status.battery_ratio, self.heard_at, rules)


@dataclass(frozen=True, slots=True)
class HistoryPoint:
    """One position of one vehicle; stamp_ns is its own clock."""

    vehicle_id: str
    boot_id: str
    received_at: datetime
    stamp_ns: int
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    mode: str
    battery_ratio: float


# Where a page of a list ended: requested or made at, and the id; for runs: started at, boot and vehicle.
MomentAndId = tuple[datetime, str]
RunPosition = tuple[datetime, str, str]


@dataclass(frozen=True, slots=True)
class IncidentPosition:
    """closed_at None: the page ended among the open ones."""

    priority: int
    closed_at: datetime | None
    opened_at: datetime
    incident_id: str


class Views(Protocol):
    """All of one campus. Lists are bounded by `limit`; `after` is the last item of the page before."""

    def vehicles(self, vehicle_ids: Set[str] | None = None) -> tuple[VehicleView, ...]:
        """By vehicle id, retired ones left out; only the named ones where some are."""
        ...

    def vehicle(self, vehicle_id: str) -> VehicleView | None: ...

    def rides(
        self,
        states: Sequence[RideState] | None = None,
        vehicle_id: str | None = None,
        limit: int = 200,
        before: datetime | None = None,
        ride_ids: Set[str] | None = None,
        after: MomentAndId | None = None,
        since: datetime | None = None,
        stop_id: str | None = None,
        ride_code: str | None = None,
    ) -> tuple[Ride, ...]:
        """Newest request first. before, since: of the request; stop_id: at either end."""
        ...

    def pickups(self, since: datetime, until: datetime) -> tuple[tuple[str, datetime], ...]:
        """Stop and earliest pickup of every ride that was wanted in [since, until), refused ones too."""
        ...

    def incidents(
        self, include_closed: bool = False, limit: int = 200, after: IncidentPosition | None = None
    ) -> tuple[Incident, ...]:
        """Open ones by urgency and age, then closed ones, newest first."""
        ...

    def runs(
        self, vehicle_id: str | None = None, limit: int = 100, after: RunPosition | None = None
    ) -> tuple[Run, ...]:
        """Newest first, with their segments in order."""
        ...

    def run(self, vehicle_id: str, boot_id: str) -> Run | None: ...

    def departures(self, limit: int = 200) -> tuple[Departure, ...]:
        """Latest first call first."""
        ...

    def vehicle_events(self, vehicle_id: str | None = None, limit: int = 200) -> tuple[RecordedEvent, ...]:
        """Newest first."""
        ...

    def server_events(self, limit: int = 200) -> tuple[ServerEvent, ...]:
        """Newest first."""
        ...

    def events_about(self, subject: str, limit: int = 200) -> tuple[ServerEvent, ...]:
        """Oldest first; of more than `limit`, the newest."""
        ...

    def history(
        self, vehicle_id: str, since: datetime, until: datetime, limit: int = 10_000
    ) -> tuple[HistoryPoint, ...]:
        """Oldest first."""
        ...
