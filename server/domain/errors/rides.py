"""Refusals of rides, bookings and recurring bookings."""

from server.domain.errors.base import DomainError


class RideUnknown(DomainError):
    """No ride has this id, code or token."""

    code = "ride_unknown"


class RideAlreadyAboard(DomainError):
    """The party is in the shuttle: it can get off early, but not cancel or board."""

    code = "ride_already_aboard"


class RideNotAboard(DomainError):
    """The party is not in the shuttle, so it cannot alight."""

    code = "ride_not_aboard"


class RideEnded(DomainError):
    """The ride is completed, refused, cancelled, missed or failed."""

    code = "ride_ended"


class RideNotEnded(DomainError):
    """The ride goes on: it can be erased after its end."""

    code = "ride_not_ended"


class RideNotCompleted(DomainError):
    """Nobody has taken this ride, or it goes on: there is nothing to rate yet."""

    code = "ride_not_completed"


class RideNotAssigned(DomainError):
    """No shuttle has the ride yet."""

    code = "ride_not_assigned"


class IllegalTransition(DomainError):
    """The requested state cannot follow the present one."""

    code = "illegal_transition"


class PartyTooLarge(DomainError):
    """More people than the largest shuttle seats."""

    code = "party_too_large"


class PartyInvalid(DomainError):
    """A party has at least one person, and no more wheelchairs than people."""

    code = "party_invalid"


class SameStop(DomainError):
    """A ride from a stop to itself."""

    code = "same_stop"


class BookingTooFarAhead(DomainError):
    """Rides cannot be booked that far ahead."""

    code = "booking_too_far_ahead"


class IdempotencyMismatch(DomainError):
    """The same Idempotency-Key was used for another booking or command."""

    code = "idempotency_mismatch"


class NoVehicleFree(DomainError):
    """No shuttle can do it; the detail names the rule that binds."""

    code = "no_vehicle_free"


class DestinationRefused(DomainError):
    """The party cannot be taken there; `rule` names the rule that binds, and the ride is unchanged."""

    code = "destination_refused"

    def __init__(self, detail: str, rule: str = "") -> None:
        super().__init__(detail)
        self.rule = rule


class RideRefused(DomainError):
    """No vehicle can take the ride, and the refused ride is not stored."""

    code = "ride_refused"

    def __init__(self, detail: str, rule: str) -> None:
        super().__init__(detail)
        self.rule = rule


class ReassignmentRefused(DomainError):
    """The vehicle cannot take the ride; `rule` names the rule that binds, and the ride is unchanged."""

    code = "reassignment_refused"

    def __init__(self, detail: str, rule: str = "") -> None:
        super().__init__(detail)
        self.rule = rule


class NoticesUnavailable(DomainError):
    """This server sends nothing to browsers."""

    code = "notices_unavailable"


class PushSubscriptionInvalid(DomainError):
    """Nothing can be sent to this address of a push service."""

    code = "push_subscription_invalid"


class SeriesUnknown(DomainError):
    """No recurring booking has this id or token, or none of its rides falls on that day."""

    code = "series_unknown"


class SeriesEnded(DomainError):
    """The recurring booking was cancelled, or its last day is past."""

    code = "series_ended"


class SeriesInvalid(DomainError):
    """The recurring booking has no day on which a ride is possible."""

    code = "series_invalid"


class OccurrenceEnded(DomainError):
    """That day's ride was removed from the recurring booking, or is over."""

    code = "occurrence_ended"
