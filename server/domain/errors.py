"""Every refusal, by name. `api/problems.py` maps each code to a status."""


class DomainError(Exception):
    """A request is refused. `code` is stable and machine-readable; `detail` says what to do.

    rule   the dispatcher's binding rule if one is the reason, "" otherwise
    """

    code = "refused"
    rule = ""

    def __init__(self, detail: str) -> None:
        super().__init__(detail)
        self.detail = detail


# ---------------------------------------------------------------- rides


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


class NoService(DomainError):
    """The campus does not run at that time, or not for long enough; the detail names when it opens."""

    code = "no_service"


class BookingTooFarAhead(DomainError):
    """Rides cannot be booked that far ahead."""

    code = "booking_too_far_ahead"


class IdempotencyMismatch(DomainError):
    """The same Idempotency-Key was used for another booking."""

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


# ---------------------------------------------------------------- the campus


class CampusUnknown(DomainError):
    """The campus has no active map."""

    code = "campus_unknown"


class MapUnknown(DomainError):
    """No map of this version is stored."""

    code = "map_unknown"


class MapInvalid(DomainError):
    """The bytes are no usable road map."""

    code = "map_invalid"


class MapInUse(DomainError):
    """Shuttles are on the road with the active map."""

    code = "map_in_use"


class AreaUnknown(DomainError):
    """The active map has no such observation area."""

    code = "area_unknown"


class StopUnknown(DomainError):
    """The active map has no such stop."""

    code = "stop_unknown"


class StopUnreachable(DomainError):
    """No road leads from the one stop to the other."""

    code = "stop_unreachable"


class PatternUnknown(DomainError):
    """No service of this name has a calendar."""

    code = "pattern_unknown"


class PatternInvalid(DomainError):
    """A calendar whose days or hours contradict each other."""

    code = "pattern_invalid"


class PatternInUse(DomainError):
    """Timetable trips run by this calendar."""

    code = "pattern_in_use"


class ExceptionUnknown(DomainError):
    """The calendar has no exception on that day."""

    code = "exception_unknown"


class ShiftsInvalid(DomainError):
    """A vehicle's shifts contradict each other or the clock."""

    code = "shifts_invalid"


class LaneUnknown(DomainError):
    """The active map has no such lane."""

    code = "lane_unknown"


class SectionUnknown(DomainError):
    """The active map has no such section."""

    code = "section_unknown"


class ClosureInvalid(DomainError):
    """A road closure closes nothing, or ends before it begins."""

    code = "closure_invalid"


class ClosureUnknown(DomainError):
    """No road closure has this id."""

    code = "closure_unknown"


class ClosureOver(DomainError):
    """The road closure has ended or was lifted already."""

    code = "closure_over"


# ---------------------------------------------------------------- vehicles, plans, orders


class VehicleUnknown(DomainError):
    """No vehicle of this id is enrolled."""

    code = "vehicle_unknown"


class VehicleNotPlaced(DomainError):
    """The vehicle has not reported a position yet, or stands on no lane."""

    code = "vehicle_not_placed"


class NobodyAboard(DomainError):
    """The vehicle has no riders who could go on with another one."""

    code = "nobody_aboard"


class VehicleOutOfService(DomainError):
    """The vehicle has been recalled; put it back into service first."""

    code = "vehicle_out_of_service"


class VehicleNotConnected(DomainError):
    """The vehicle has no open session, so it cannot receive anything now."""

    code = "vehicle_not_connected"


class PlanChanged(DomainError):
    """The plan was changed in the meantime: read again, decide again."""

    code = "plan_changed"


class VisitUnknown(DomainError):
    """The plan has no such visit."""

    code = "visit_unknown"


class OrderUnknown(DomainError):
    """The vehicle names an order that the server never issued."""

    code = "order_unknown"


class NoRestingPlaceFree(DomainError):
    """Every resting place that the vehicle can reach is reserved for another one."""

    code = "no_resting_place_free"


class SectionsTaken(DomainError):
    """The vehicle stands on sections that another one holds."""

    code = "sections_taken"


class CommandUnknown(DomainError):
    """The server gave no such command."""

    code = "command_unknown"


class SessionFenced(DomainError):
    """A newer session of the same vehicle has taken over."""

    code = "session_fenced"


# ---------------------------------------------------------------- runs and incidents


class RunUnknown(DomainError):
    """No run of this vehicle and boot is stored."""

    code = "run_unknown"


class RunMapUnreadable(DomainError):
    """The run's recording holds no road map that can be drawn."""

    code = "run_map_unreadable"


class SegmentUnknown(DomainError):
    """No segment has this hash."""

    code = "segment_unknown"


class SegmentConflict(DomainError):
    """The same segment number of a run came with other content."""

    code = "segment_conflict"


class IncidentUnknown(DomainError):
    """No incident has this id."""

    code = "incident_unknown"


class IncidentClosed(DomainError):
    """The incident is closed already."""

    code = "incident_closed"


# ---------------------------------------------------------------- identity


class KeyUnknown(DomainError):
    """No valid key is enrolled for this vehicle, or the signature does not fit it."""

    code = "key_unknown"


class KeyInvalid(DomainError):
    """Not an Ed25519 public key in base64."""

    code = "key_invalid"


class EnrolmentCodeUnknown(DomainError):
    """No such enrolment code, or it has expired."""

    code = "enrolment_code_unknown"


class EnrolmentCodeUsed(DomainError):
    """An enrolment code works once."""

    code = "enrolment_code_used"


class NameTaken(DomainError):
    """The name is already in use."""

    code = "name_taken"


class WrongCredentials(DomainError):
    """Name and password do not match; the answer does not say which one is wrong."""

    code = "wrong_credentials"


class SessionExpired(DomainError):
    """The operator's session is over or was never opened: log in again."""

    code = "session_expired"


class TokenInvalid(DomainError):
    """The developer token is unknown, expired or revoked."""

    code = "token_invalid"


class ScopeMissing(DomainError):
    """The developer token does not allow this."""

    code = "scope_missing"


class LeaseLost(DomainError):
    """Another replica has taken over the task."""

    code = "lease_lost"
