"""Script a Campusloop campus: rides, vehicles, commands, closures, and live updates."""

from campusloop_sdk.campus import Campus, connect
from campusloop_sdk.errors import (
    AnswerUnreadable,
    CampusError,
    Conflict,
    ConnectionLost,
    FieldProblem,
    Invalid,
    NotAllowed,
    NotFound,
    RequestRefused,
    ServerFault,
    TooMany,
)
from campusloop_sdk.live import Live
from campusloop_sdk.live_models import (
    EventUpdate,
    LiveRide,
    LiveVehicle,
    RidesUpdate,
    Topic,
    Update,
    VehiclesUpdate,
)
from campusloop_sdk.models import (
    BookedRide,
    Closure,
    Ride,
    Stop,
    Vehicle,
    VehicleCommand,
    VehicleRecord,
    Visit,
)

__all__ = [
    "AnswerUnreadable",
    "BookedRide",
    "Campus",
    "CampusError",
    "Closure",
    "Conflict",
    "ConnectionLost",
    "EventUpdate",
    "FieldProblem",
    "Invalid",
    "Live",
    "LiveRide",
    "LiveVehicle",
    "NotAllowed",
    "NotFound",
    "RequestRefused",
    "Ride",
    "RidesUpdate",
    "ServerFault",
    "Stop",
    "TooMany",
    "Topic",
    "Update",
    "Vehicle",
    "VehicleCommand",
    "VehicleRecord",
    "VehiclesUpdate",
    "Visit",
    "connect",
]
