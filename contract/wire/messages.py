"""Everything a vehicle and the server say to each other.

One frozen struct a message, tagged by `type`. Stamps that end in `_ns` are the speaker's clock: on the
vehicle monotonic nanoseconds since its boot, on the server UTC nanoseconds since the Unix epoch. The hello
exchange ties the two together (`ClockSample`). Schema evolution is additive; a breaking change raises
`PROTOCOL_VERSION`.

The messages of one concern are in one file: session, orders, commands, status, events, maps,
infrastructure. Others import them from here.
"""

from contract.wire.base import Message
from contract.wire.camera_picture import CameraPicture
from contract.wire.commands import LATER_KINDS, Command, CommandKind, PassengerTap
from contract.wire.events import (
    Blocked,
    BoardedHow,
    CodeRefused,
    CommandDone,
    DestinationRequested,
    DoorsChanged,
    Event,
    EventLogState,
    EventReport,
    EventsAcknowledged,
    FaultRaised,
    HelpRequested,
    LocalizationMapFailed,
    LocalizationMapStored,
    MapChangeFailed,
    ModeChanged,
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    RiderNoShow,
    ScansReported,
    SeatButtonPressed,
    SectionReleased,
    TapAnswered,
    VehicleEvent,
    VisitChanged,
)
from contract.wire.infrastructure import Presence, PresenceRefused, PresenceReport
from contract.wire.localization_maps import LocalizationMapPublished
from contract.wire.maps import MapPublished
from contract.wire.onboard_scene import (
    LimitAhead,
    OnboardScene,
    PathTimes,
    PathTrack,
    RoomTime,
    ShownScan,
    ShownSign,
    ShownTrack,
    TickTimes,
    TracksBy,
)
from contract.wire.orders import (
    Grants,
    Order,
    OrderAccepted,
    OrderProgress,
    OrderRejected,
    RiderTask,
    SectionGrant,
    Visit,
    VisitKind,
    VisitProgress,
    VisitState,
)
from contract.wire.scans import SCANS_REQUESTED, ScanArea, ScansRequested
from contract.wire.session import (
    OLDEST_PROTOCOL_VERSION,
    PROTOCOL_VERSION,
    Challenge,
    ClockProbe,
    ClockSample,
    Goodbye,
    Hello,
    Welcome,
    signed_hello,
)
from contract.wire.status import (
    AreaReport,
    DriveMode,
    DrivingView,
    FaultReport,
    FleetVehicle,
    Headlights,
    LocalizationReport,
    Status,
    TrackReport,
    TurnSignal,
)

__all__ = (
    "LATER_KINDS",
    "OLDEST_PROTOCOL_VERSION",
    "PROTOCOL_VERSION",
    "SCANS_REQUESTED",
    "AreaReport",
    "Blocked",
    "BoardedHow",
    "CameraPicture",
    "Challenge",
    "ClockProbe",
    "ClockSample",
    "CodeRefused",
    "Command",
    "CommandDone",
    "CommandKind",
    "DestinationRequested",
    "DoorsChanged",
    "DriveMode",
    "DrivingView",
    "Event",
    "EventLogState",
    "EventReport",
    "EventsAcknowledged",
    "FaultRaised",
    "FaultReport",
    "FleetVehicle",
    "Goodbye",
    "Grants",
    "Headlights",
    "Hello",
    "HelpRequested",
    "LimitAhead",
    "LocalizationMapFailed",
    "LocalizationMapPublished",
    "LocalizationMapStored",
    "LocalizationReport",
    "MapChangeFailed",
    "MapPublished",
    "Message",
    "ModeChanged",
    "OnboardScene",
    "Order",
    "OrderAccepted",
    "OrderProgress",
    "OrderRejected",
    "PassengerTap",
    "PathTimes",
    "PathTrack",
    "Presence",
    "PresenceRefused",
    "PresenceReport",
    "RiderAlighted",
    "RiderBoarded",
    "RiderDidNotAlight",
    "RiderNoShow",
    "RiderTask",
    "RoomTime",
    "ScanArea",
    "ScansReported",
    "ScansRequested",
    "SeatButtonPressed",
    "SectionGrant",
    "SectionReleased",
    "ServerMessage",
    "ShownScan",
    "ShownSign",
    "ShownTrack",
    "Status",
    "TapAnswered",
    "TickTimes",
    "TrackReport",
    "TracksBy",
    "TurnSignal",
    "VehicleEvent",
    "VehicleMessage",
    "Visit",
    "VisitChanged",
    "VisitKind",
    "VisitProgress",
    "VisitState",
    "Welcome",
    "signed_hello",
)

VehicleMessage = (
    Hello | ClockProbe | Status | OrderAccepted | OrderRejected | EventReport | OnboardScene | CameraPicture
)
ServerMessage = (
    Challenge
    | Welcome
    | ClockSample
    | Order
    | Grants
    | Command
    | PassengerTap
    | FleetVehicle
    | Presence
    | EventsAcknowledged
    | MapPublished
    | ScansRequested
    | LocalizationMapPublished
    | Goodbye
)
