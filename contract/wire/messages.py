"""Everything a vehicle and the server say to each other.

One frozen struct a message, tagged by `type`. Stamps that end in `_ns` are the speaker's clock: on the
vehicle monotonic nanoseconds since its boot, on the server UTC nanoseconds since the Unix epoch. The hello
exchange ties the two together (`ClockSample`). Schema evolution is additive; a breaking change raises
`PROTOCOL_VERSION`.
"""

from typing import Annotated, Literal

import msgspec

from contract.geometry import Pose2
from contract.wire.reasons import FaultCode, FaultSeverity, HoldReason, SpeedLimitReason

PROTOCOL_VERSION = 1
OLDEST_PROTOCOL_VERSION = 1

VisitState = Literal["pending", "under_way", "done", "skipped"]
VisitKind = Literal["stop", "rest", "temporary"]
BoardedHow = Literal["code", "tap", "sensor"]
DriveMode = Literal["autonomous", "held", "manual", "minimal_risk", "fault"]


class Message(msgspec.Struct, frozen=True, tag_field="type", forbid_unknown_fields=False):
    """Base of everything on the wire."""


# ---------------------------------------------------------------- session


class Challenge(Message, frozen=True, tag="challenge"):
    """Server, first: sign this nonce. Also the protocol versions it speaks and its send time."""

    nonce: str
    protocol_min: int
    protocol_max: int
    server_ns: int


class VisitProgress(msgspec.Struct, frozen=True):
    visit_id: str
    state: VisitState


class OrderProgress(msgspec.Struct, frozen=True):
    """The order that the vehicle follows and how far it has come: its own record of what has happened."""

    order_id: str
    revision: int
    visits: tuple[VisitProgress, ...]
    sections: tuple[str, ...] = ()


class EventLogState(msgspec.Struct, frozen=True):
    """The first event of a boot that the server has not acknowledged yet.

    next_sequence  the number that the boot's next event will get: everything below it is on its way, and the
                   server waits for it before it sends an order; 0 for unknown
    """

    boot_id: str
    first_unacknowledged: int
    next_sequence: int = 0


class Hello(Message, frozen=True, tag="hello"):
    """Vehicle: who I am, what I hold. `signature` is Ed25519 over `signed_hello(...)`, base64."""

    protocol: int
    vehicle_id: str
    boot_id: str
    nonce: str
    signature: str
    software: str
    stack: str
    map_version: str
    vehicle_ns: int
    event_logs: tuple[EventLogState, ...] = ()
    progress: OrderProgress | None = None
    seats: int = 6
    wheelchair_places: int = 0


class Welcome(Message, frozen=True, tag="welcome"):
    """Server: you are in. Frames of an older epoch are refused from here on."""

    epoch: int
    protocol: int
    server_ns: int
    acknowledged: tuple[EventLogState, ...] = ()


class ClockProbe(Message, frozen=True, tag="clock_probe"):
    vehicle_ns: int


class ClockSample(Message, frozen=True, tag="clock_sample"):
    """Server's answer to a probe; with the arrival stamp the vehicle has offset and round trip."""

    vehicle_ns: int
    server_ns: int


# ---------------------------------------------------------------- orders, server -> vehicle


class RiderTask(msgspec.Struct, frozen=True):
    """One ride's party at a visit. The code is what a rider types on the onboard screen."""

    ride_id: str
    party: int
    code: str = ""


class Visit(msgspec.Struct, frozen=True):
    """Go to a place and stand there.

    route       lanes from the end of the visit before (or from where the order was made) to `lane_id`,
                both ends included; empty when the vehicle already stands there
    s_m         where the rear axle shall stand on `lane_id`
    dwell_s     how long doors stay open at least, once standing
    not_before_ns  server time up to which the vehicle waits for those who board here, 0 for none
    timed       a timetable departure: nobody is waited for by name, and nobody's being aboard ends the wait
    """

    visit_id: str
    kind: VisitKind
    stop_id: str
    lane_id: str
    s_m: float
    route: tuple[str, ...]
    board: tuple[RiderTask, ...] = ()
    alight: tuple[RiderTask, ...] = ()
    dwell_s: float = 15.0
    not_before_ns: int = 0
    timed: bool = False
    name: str = ""
    name_en: str = ""


class SectionGrant(msgspec.Struct, frozen=True, array_like=True):
    """A reservation: this vehicle alone may enter the section. A higher fence replaces a lower one."""

    section_id: str
    fence: int


class Order(Message, frozen=True, tag="order"):
    """What shall happen. A higher revision replaces a lower one; repeats are harmless.

    visits      in driving order, done ones left out; the last one is a rest visit
    sections    every grant the vehicle holds, in route order
    expires_ns  server time after which the vehicle must not accept this order any more
    """

    epoch: int
    order_id: str
    revision: int
    map_version: str
    visits: tuple[Visit, ...]
    sections: tuple[SectionGrant, ...]
    expires_ns: int


class Grants(Message, frozen=True, tag="grants"):
    """All sections granted for the order's remaining route, in route order; replaces earlier lists."""

    epoch: int
    order_id: str
    sections: tuple[SectionGrant, ...]


class Command(Message, frozen=True, tag="command"):
    """An operator's or developer's word to one vehicle. Repeats of a command_id are harmless."""

    epoch: int
    command_id: str
    kind: Literal["hold", "resume", "announce", "stop_now"]
    text: str = ""


class PassengerTap(Message, frozen=True, tag="passenger_tap"):
    """A passenger tapped on the phone. The vehicle accepts it only while it stands with doors open."""

    epoch: int
    tap_id: str
    ride_id: str
    kind: Literal["board", "alight"]


class FleetVehicle(Message, frozen=True, tag="fleet_vehicle"):
    """Where another vehicle of the fleet is. Neither acknowledged nor repeated; the next status replaces it.

    server_ns: when the server received that vehicle's status
    """

    epoch: int
    vehicle_id: str
    server_ns: int
    pose_map: Pose2
    speed_mps: float


class Presence(Message, frozen=True, tag="presence"):
    """How many people an infrastructure camera sees in an area. Neither acknowledged nor repeated.

    server_ns: when the camera took its picture, in the server's clock
    """

    epoch: int
    area_id: str
    server_ns: int
    count: int


class EventsAcknowledged(Message, frozen=True, tag="events_acknowledged"):
    """The server has stored every event of this boot below `next_sequence`."""

    epoch: int
    boot_id: str
    next_sequence: int


class Goodbye(Message, frozen=True, tag="goodbye"):
    """Server, before it closes: why, as a typed code, and what to do about it."""

    code: str
    detail: str


# ---------------------------------------------------------------- status and answers, vehicle -> server


class FaultReport(msgspec.Struct, frozen=True):
    code: FaultCode
    severity: FaultSeverity
    since_ns: int


class TrackReport(msgspec.Struct, frozen=True, array_like=True):
    """Somebody or something that moves, as the vehicle sees it; map frame, metres.

    kind        "pedestrian", "cyclist", "vehicle" or "other"
    yielded_to  the vehicle slows or stops for it
    ahead       where it is expected: x and y after 1, 2, 3 ... seconds; empty for who stands
    """

    track_id: int
    kind: str
    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float
    yielded_to: bool = False
    ahead: tuple[float, ...] = ()


class AreaReport(msgspec.Struct, frozen=True):
    """An observation area that the vehicle watches.

    track_count   how many of its own tracks are in the area or about to enter it
    camera_count  how many people an infrastructure camera counts there, -1 without a report
    camera_age_s  age of that report
    """

    area_id: str
    track_count: int = 0
    camera_count: int = -1
    camera_age_s: float = 0.0


class DrivingView(msgspec.Struct, frozen=True):
    """What the vehicle sees and plans, for screens only. No decision uses it; the run log alone stores it.

    limited_by  what keeps the vehicle from going faster; a section that is not granted is in `waiting_for`
    path        x0, y0, x1, y1, ... of the rear axle's planned way, thinned
    tracks      the nearest ones
    """

    limited_by: SpeedLimitReason | None = None
    path: tuple[float, ...] = ()
    tracks: tuple[TrackReport, ...] = ()
    areas: tuple[AreaReport, ...] = ()


class Status(Message, frozen=True, tag="status"):
    """Where the vehicle is and what it does; latest wins.

    hold_reason, hold_detail  why the vehicle does not drive by itself, None when it does; detail: the
                              operator's own text, or which visit is unreachable
    """

    epoch: int
    stamp_ns: int
    pose_map: Pose2
    speed_mps: float
    accel_mps2: float
    steer_rad: float
    mode: DriveMode
    battery_ratio: float
    doors_open: bool
    lane_id: str
    s_m: float
    order_id: str
    revision: int
    visit_id: str
    aboard: tuple[str, ...] = ()
    screen: str = ""
    spoken: str = ""
    obstacle_m: float | None = None
    waiting_for: str = ""
    faults: tuple[FaultReport, ...] = ()
    driving: DrivingView | None = None
    hold_reason: HoldReason | None = None
    hold_detail: str = ""


class OrderAccepted(Message, frozen=True, tag="order_accepted"):
    """The vehicle has the order on disk and follows it."""

    epoch: int
    order_id: str
    revision: int


class OrderRejected(Message, frozen=True, tag="order_rejected"):
    """The vehicle keeps what it had. `visits` is its own state, so that the server can mend its plan."""

    epoch: int
    order_id: str
    revision: int
    code: Literal["visit_under_way", "expired", "map_version", "stale_revision", "unreachable", "malformed"]
    detail: str
    visits: tuple[VisitProgress, ...] = ()


# ---------------------------------------------------------------- events, vehicle -> server, durable


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
    """Somebody typed a code that belongs to no rider of this visit."""

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


VehicleMessage = Hello | ClockProbe | Status | OrderAccepted | OrderRejected | EventReport
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
    | Goodbye
)


# ---------------------------------------------------------------- infrastructure cameras


class PresenceReport(Message, frozen=True, tag="presence_report"):
    """Camera, once to ten times a second: how many people are in an observation area; latest wins.

    age_s  since the picture was taken, by the camera's own clock: it needs no other one
    """

    area_id: Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
    count: Annotated[int, msgspec.Meta(ge=0, le=1000)]
    age_s: Annotated[float, msgspec.Meta(ge=0.0, le=10.0)] = 0.0


class PresenceRefused(Message, frozen=True, tag="presence_refused"):
    """Server: this word was not taken, and why. The connection stays open unless the token is at fault."""

    code: str
    detail: str


def signed_hello(nonce: str, vehicle_id: str, boot_id: str, protocol: int) -> bytes:
    """The bytes that a vehicle's key signs; bound to one nonce, so that a copied hello opens nothing."""
    return f"campusloop-hello\n{protocol}\n{nonce}\n{vehicle_id}\n{boot_id}".encode()
