"""Refusals of vehicles, their shifts, sessions and commands."""

from server.domain.errors.base import DomainError


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


class VehicleMoves(DomainError):
    """The vehicle moves, so a place that is named for it is not its own when it hears of it."""

    code = "vehicle_moves"


class ShiftsInvalid(DomainError):
    """A vehicle's shifts contradict each other or the clock."""

    code = "shifts_invalid"


class CommandUnknown(DomainError):
    """The server gave no such command."""

    code = "command_unknown"


class SessionFenced(DomainError):
    """A newer session of the same vehicle has taken over."""

    code = "session_fenced"
