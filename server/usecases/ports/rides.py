"""Rides, recurring bookings and the decisions about them."""

from collections.abc import Mapping, Sequence
from datetime import date, datetime
from typing import Protocol

from server.domain.planning.decisions import Decision, RideDecision
from server.domain.rides.feedback import Feedback
from server.domain.rides.notices import PushSubscription
from server.domain.rides.rides import Ride, RideState, Tap
from server.domain.rides.series import Occurrence, Series, SeriesState
from server.usecases.ports.views import MomentAndId


class RideRepository(Protocol):
    def get(self, ride_id: str) -> Ride | None: ...

    def by_code(self, ride_code: str) -> Ride | None:
        """The newest ride of this code that has not ended, else the newest."""
        ...

    def by_old_token(self, token_sha256: str) -> Ride | None:
        """The ride whose link was made before links were derived from keys."""
        ...

    def by_idempotency_key(self, key: str) -> Ride | None: ...

    def in_states(self, states: Sequence[RideState]) -> tuple[Ride, ...]:
        """Oldest request first."""
        ...

    def of_vehicle(self, vehicle_id: str, states: Sequence[RideState]) -> tuple[Ride, ...]: ...

    def wanted_between(self, begins: datetime, ends: datetime) -> tuple[Ride, ...]:
        """Rides in any state whose earliest pickup lies in [begins, ends); oldest request first."""
        ...

    def code_in_use(self, ride_code: str) -> bool: ...

    def add(self, ride: Ride) -> None: ...

    def save(self, ride: Ride) -> None: ...

    def adopt_ticket_key(self, key_id: str) -> int:
        """Give this key to ended rides that have none; how many there were."""
        ...

    def named_before(self, moment: datetime, limit: int) -> tuple[str, ...]:
        """The ids of rides that ended before it and are not erased, oldest first."""
        ...

    def erase(self, rides: Sequence[Ride]) -> None:
        """Store erased rides, and drop their links of before there were ticket keys, taps and feedback."""
        ...

    def save_feedback(self, feedback: Feedback) -> None:
        """In place of what was told of this ride before."""
        ...

    def feedback_of(self, ride_ids: Sequence[str]) -> Mapping[str, Feedback]:
        """By ride id; rides without any are left out."""
        ...

    def add_tap(self, tap: Tap) -> None: ...

    def save_tap(self, tap: Tap) -> None: ...

    def tap(self, tap_id: str) -> Tap | None: ...

    def pending_taps(self, vehicle_id: str) -> tuple[Tap, ...]: ...


class SeriesRepository(Protocol):
    def get(self, series_id: str) -> Series | None: ...

    def by_old_token(self, token_sha256: str) -> Series | None:
        """The booking whose link was made before links were derived from keys."""
        ...

    def by_idempotency_key(self, key: str) -> Series | None: ...

    def listed(
        self,
        states: Sequence[SeriesState] | None = None,
        limit: int | None = None,
        after: MomentAndId | None = None,
    ) -> tuple[Series, ...]:
        """Newest first; `after` is the last one of the page before."""
        ...

    def add(self, series: Series) -> None: ...

    def save(self, series: Series) -> None: ...

    def ended_before(self, moment: datetime, limit: int) -> tuple[str, ...]:
        """Ids, oldest first."""
        ...

    def unlink_rides(self, ride_ids: Sequence[str]) -> None:
        """No day names these rides any more."""
        ...

    def erase(self, series_id: str) -> None:
        """Drop it and its days."""
        ...

    def occurrence(self, series_id: str, day: date) -> Occurrence | None: ...

    def occurrences(self, series_id: str) -> tuple[Occurrence, ...]:
        """Those that something has happened to, by day."""
        ...

    def occurrences_between(self, first: date, last: date) -> tuple[Occurrence, ...]:
        """Those of all series on these days, both included."""
        ...

    def save_occurrence(self, occurrence: Occurrence) -> None: ...


class PushSubscriptionRepository(Protocol):
    def get(self, ride_id: str, subscription_id: str) -> PushSubscription | None: ...

    def of_ride(self, ride_id: str) -> tuple[PushSubscription, ...]:
        """Oldest first."""
        ...

    def all(self) -> tuple[PushSubscription, ...]:
        """Oldest first."""
        ...

    def save(self, subscription: PushSubscription) -> None:
        """New, or in place of the one of this ride and id."""
        ...

    def remove(self, subscription: PushSubscription) -> None: ...

    def remove_of_rides(self, ride_ids: Sequence[str]) -> None: ...


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
