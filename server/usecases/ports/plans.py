"""Plans, orders, sections, and what driving takes."""

from datetime import datetime
from typing import Protocol

from server.domain.orders.orders import IssuedOrder
from server.domain.orders.sections import HeldSection, Occupancy
from server.domain.planning.plans import Plan
from server.domain.planning.travel_time_factors import DrivenLeg, TravelTimeFactors


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

    def has_named(self, vehicle_id: str, ride_id: str) -> bool:
        """Some order that was ever issued to the vehicle has the ride's party board or alight."""
        ...

    def add(self, order: IssuedOrder) -> None: ...

    def save(self, order: IssuedOrder) -> None: ...


class SectionRepository(Protocol):
    def all(self) -> tuple[Occupancy, ...]:
        """Every vehicle on the road, by vehicle id."""
        ...

    def held_by(self, vehicle_id: str) -> tuple[HeldSection, ...]:
        """The sections that one vehicle holds."""
        ...

    def save(self, occupancy: Occupancy) -> None: ...

    def remove(self, vehicle_id: str) -> None: ...

    def next_fence(self) -> int:
        """Higher than any fence given before on this campus."""
        ...

    def skip_fences(self, count: int) -> None:
        """Give so many to no one: vehicles may have them from a newer database than this one."""
        ...


class TravelTimeFactorRepository(Protocol):
    def begin_leg(self, vehicle_id: str, from_stop: str, left_at: datetime) -> None: ...

    def end_leg(self, vehicle_id: str) -> tuple[str, datetime] | None:
        """Where and when the leg under way began, None for none; there is none any more."""
        ...

    def add(self, leg: DrivenLeg) -> None: ...

    def legs(self) -> tuple[DrivenLeg, ...]:
        """Oldest first."""
        ...

    def forget_before(self, moment: datetime) -> int: ...

    def present(self) -> TravelTimeFactors | None: ...

    def save(self, factors: TravelTimeFactors) -> None: ...
