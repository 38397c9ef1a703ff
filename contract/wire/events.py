"""What has happened on a vehicle. Its outbox keeps the numbered events until the server acknowledges them."""

from typing import Annotated, Literal

import msgspec

from contract.geometry import Pose2
from contract.wire.base import Message
from contract.wire.bounds import ArcLength, Count, Distance, Id, LongText, PlaceId, Places, StampNs
from contract.wire.localization_maps import LocalizationMapFailure
from contract.wire.maps import MapFailure
from contract.wire.orders import VisitState
from contract.wire.reasons import FaultCode, HoldReason
from contract.wire.scans import ScanState
from contract.wire.status import DriveMode, FaultReport

BoardedHow = Literal["code", "tap", "sensor"]


class Event(msgspec.Struct, frozen=True, tag_field="event"):
    """Base of what has happened on a vehicle."""


class VisitChanged(Event, frozen=True, tag="visit_changed"):
    visit_id: Id
    stop_id: PlaceId
    state: VisitState


class DoorsChanged(Event, frozen=True, tag="doors_changed"):
    open: bool
    visit_id: Id


class RiderBoarded(Event, frozen=True, tag="rider_boarded"):
    ride_id: Id
    how: BoardedHow


class RiderAlighted(Event, frozen=True, tag="rider_alighted"):
    ride_id: Id
    how: BoardedHow


class RiderNoShow(Event, frozen=True, tag="rider_no_show"):
    ride_id: Id


class RiderDidNotAlight(Event, frozen=True, tag="rider_did_not_alight"):
    ride_id: Id


class SeatButtonPressed(Event, frozen=True, tag="seat_button_pressed"):
    """A passenger wants to get off early. Acted on at once onboard; `s_m` is where the vehicle will stop.

    accepted is False when no place for stopping lies before the next visit; reason says so.
    """

    seat: Places
    accepted: bool
    visit_id: Id
    lane_id: PlaceId
    s_m: ArcLength
    reason: LongText = ""


class SectionReleased(Event, frozen=True, tag="section_released"):
    section_id: PlaceId
    fence: Count


class ModeChanged(Event, frozen=True, tag="mode_changed"):
    """reason: why the vehicle does not drive by itself; detail: see `Status`; faults: those that hold it."""

    mode: DriveMode
    reason: HoldReason | None = None
    detail: LongText = ""
    faults: Annotated[tuple[FaultCode, ...], msgspec.Meta(max_length=100)] = ()


class Blocked(Event, frozen=True, tag="blocked"):
    """Standing for something in the path; `cleared` ends the incident."""

    since_ns: StampNs
    cleared: bool
    obstacle_m: Distance
    pose_map: Pose2


class FaultRaised(Event, frozen=True, tag="fault_raised"):
    fault: FaultReport
    cleared: bool = False


class CommandDone(Event, frozen=True, tag="command_done"):
    command_id: Id
    done: bool
    detail: LongText = ""


class TapAnswered(Event, frozen=True, tag="tap_answered"):
    tap_id: Id
    ride_id: Id
    accepted: bool
    reason: LongText = ""


class CodeRefused(Event, frozen=True, tag="code_refused"):
    """A code was typed that belongs to no rider of this visit."""

    visit_id: Id


class HelpRequested(Event, frozen=True, tag="help_requested"):
    """A passenger calls for help on the onboard screen or by a button. seat: 0 if it is not known."""

    seat: Places


class DestinationRequested(Event, frozen=True, tag="destination_requested"):
    """A party aboard wants to go to another stop. The server decides; the order shows what it decided."""

    ride_id: Id
    stop_id: PlaceId


class MapChangeFailed(Event, frozen=True, tag="map_change_failed"):
    """The vehicle keeps the map that it has, and tries again. Only after `MapPublished`."""

    map_version: Id
    code: MapFailure
    detail: LongText = ""


class ScansReported(Event, frozen=True, tag="scans_reported"):
    """What the vehicle does about a request for lidar scans has changed. Only after `ScansRequested`.

    scans, way_m, bytes_kept  of this request since it began: kept by the vehicle, uploaded or not
    """

    request_id: Id
    state: ScanState
    scans: Count
    way_m: Distance
    bytes_kept: Count
    detail: LongText = ""


class LocalizationMapStored(Event, frozen=True, tag="localization_map_stored"):
    """The vehicle has all tiles, and changes over when it stands. Only after `LocalizationMapPublished`."""

    map_version: Id


class LocalizationMapFailed(Event, frozen=True, tag="localization_map_failed"):
    """The vehicle keeps the localization map that it has, and tries again. As `LocalizationMapStored`."""

    map_version: Id
    code: LocalizationMapFailure
    detail: LongText = ""


VehicleEvent = (
    VisitChanged
    | DoorsChanged
    | RiderBoarded
    | RiderAlighted
    | RiderNoShow
    | RiderDidNotAlight
    | SeatButtonPressed
    | SectionReleased
    | ModeChanged
    | Blocked
    | FaultRaised
    | CommandDone
    | TapAnswered
    | CodeRefused
    | HelpRequested
    | DestinationRequested
    | MapChangeFailed
    | ScansReported
    | LocalizationMapStored
    | LocalizationMapFailed
)


class EventReport(Message, frozen=True, tag="event"):
    """One event on its way up. (vehicle, boot_id, sequence) names it for ever: effects happen once."""

    epoch: Count
    boot_id: Id
    sequence: Count
    stamp_ns: StampNs
    body: VehicleEvent


class EventLogState(msgspec.Struct, frozen=True):
    """The first event of a boot that the server has not acknowledged yet.

    next_sequence  the number that the boot's next event will get: everything below it is on its way, and the
                   server waits for it before it sends an order; 0 for unknown
    """

    boot_id: Id
    first_unacknowledged: Count
    next_sequence: Count = 0


class EventsAcknowledged(Message, frozen=True, tag="events_acknowledged"):
    """The server has stored every event of this boot below `next_sequence`."""

    epoch: Count
    boot_id: Id
    next_sequence: Count
