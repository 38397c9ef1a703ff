"""What has happened on a vehicle. Its outbox keeps the numbered events until the server acknowledges them."""

from typing import Literal

import msgspec

from contract.geometry import Pose2
from contract.wire.base import Message
from contract.wire.orders import VisitState
from contract.wire.reasons import FaultCode, HoldReason
from contract.wire.status import DriveMode, FaultReport

BoardedHow = Literal["code", "tap", "sensor"]


class Event(msgspec.Struct, frozen=True, tag_field="event"):
    """Base of what has happened on a vehicle."""


class VisitChanged(Event, frozen=True, tag="visit_changed"):
    visit_id: str
    stop_id: str
    state: VisitState


class DoorsChanged(Event, frozen=True, tag="doors_changed"):
    open: bool
    visit_id: str


class RiderBoarded(Event, frozen=True, tag="rider_boarded"):
    ride_id: str
    how: BoardedHow


class RiderAlighted(Event, frozen=True, tag="rider_alighted"):
    ride_id: str
    how: BoardedHow


class RiderNoShow(Event, frozen=True, tag="rider_no_show"):
    ride_id: str


class RiderDidNotAlight(Event, frozen=True, tag="rider_did_not_alight"):
    ride_id: str


class SeatButtonPressed(Event, frozen=True, tag="seat_button_pressed"):
    """A passenger wants to get off early. Acted on at once onboard; `s_m` is where the vehicle will stop.

    accepted is False when no place for stopping lies before the next visit; reason says so.
    """

    seat: int
    accepted: bool
    visit_id: str
    lane_id: str
    s_m: float
    reason: str = ""


class SectionReleased(Event, frozen=True, tag="section_released"):
    section_id: str
    fence: int


class ModeChanged(Event, frozen=True, tag="mode_changed"):
    """reason: why the vehicle does not drive by itself; detail: see `Status`; faults: those that hold it."""

    mode: DriveMode
    reason: HoldReason | None = None
    detail: str = ""
    faults: tuple[FaultCode, ...] = ()


class Blocked(Event, frozen=True, tag="blocked"):
    """Standing for something in the path; `cleared` ends the incident."""

    since_ns: int
    cleared: bool
    obstacle_m: float
    pose_map: Pose2


class FaultRaised(Event, frozen=True, tag="fault_raised"):
    fault: FaultReport
    cleared: bool = False


class CommandDone(Event, frozen=True, tag="command_done"):
    command_id: str
    done: bool
    detail: str = ""


class TapAnswered(Event, frozen=True, tag="tap_answered"):
    tap_id: str
    ride_id: str
    accepted: bool
    reason: str = ""


class CodeRefused(Event, frozen=True, tag="code_refused"):
    """A code was typed that belongs to no rider of this visit."""

    visit_id: str


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
)


class EventReport(Message, frozen=True, tag="event"):
    """One event on its way up. (vehicle, boot_id, sequence) names it for ever: effects happen once."""

    epoch: int
    boot_id: str
    sequence: int
    stamp_ns: int
    body: VehicleEvent


class EventLogState(msgspec.Struct, frozen=True):
    """The first event of a boot that the server has not acknowledged yet.

    next_sequence  the number that the boot's next event will get: everything below it is on its way, and the
                   server waits for it before it sends an order; 0 for unknown
    """

    boot_id: str
    first_unacknowledged: int
    next_sequence: int = 0


class EventsAcknowledged(Message, frozen=True, tag="events_acknowledged"):
    """The server has stored every event of this boot below `next_sequence`."""

    epoch: int
    boot_id: str
    next_sequence: int
