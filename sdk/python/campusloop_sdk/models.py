"""The server's answers. Times are aware datetimes; positions are metres in the map frame.

Only what a script needs is listed: fields that a newer server adds are ignored.
"""

from datetime import datetime
from typing import Literal

import msgspec

RideState = Literal[
    "requested", "assigned", "boarding", "aboard", "completed", "refused", "cancelled", "no_show", "failed"
]
CommandKind = Literal[
    "hold",
    "resume",
    "announce",
    "stop_now",
    "mark",
    "start_recording",
    "stop_recording",
    "show_scene",
    "set_position",
    "show_camera",
]
CommandState = Literal["pending", "done", "failed"]


class Stop(msgspec.Struct, frozen=True):
    stop_id: str
    name: str
    name_en: str
    x_m: float
    y_m: float


class Promise(msgspec.Struct, frozen=True):
    """The party is picked up within [pickup_from, pickup_to] and is there by arrive_by."""

    pickup_from: datetime
    pickup_to: datetime
    arrive_by: datetime


class Feedback(msgspec.Struct, frozen=True):
    """What the passenger said after the ride. rating: 1 (bad) to 5 (good), None for none."""

    rating: int | None
    made_at: datetime


class Alternative(msgspec.Struct, frozen=True):
    """What would have been accepted when a ride was refused. Nothing is reserved: book it again.

    parties  people in each ride, one or two of them
    walk_s   additional walking, in seconds
    pickup_at, arrival_at  of each ride, as planned
    """

    kind: Literal["later", "other_stops", "split_party"]
    from_stop: str
    to_stop: str
    parties: tuple[int, ...]
    walk_s: float
    pickup_at: tuple[datetime, ...]
    arrival_at: tuple[datetime, ...]


class Offer(msgspec.Struct, frozen=True):
    """What a booking would get now. rule: the rule that binds, "" where a shuttle is free."""

    is_free: bool
    rule: str
    pickup_at: datetime | None
    arrival_at: datetime | None


class Ride(msgspec.Struct, frozen=True):
    """A ride. A refused one has no promise, and `reason` names the rule that binds.

    pickup_earliest, pickup_latest    the shuttle comes between them in 9 of 10 cases; None while no time can
                                      be told
    arrival_earliest, arrival_latest  the same for the arrival
    seats_left     free seats beside the party, on the fullest part of the ride; None while not known
    first_promise  if the first one could not be kept
    feedback       after the ride, if the passenger gave any
    """

    ride_id: str
    ride_code: str
    state: RideState
    from_stop: str
    to_stop: str
    party: int
    wheelchairs: int
    earliest: datetime
    requested_at: datetime
    promise: Promise | None
    vehicle_id: str | None
    pickup_eta: datetime | None
    arrival_eta: datetime | None
    reason: str
    reason_detail: str
    vehicle_name: str = ""
    pickup_earliest: datetime | None = None
    pickup_latest: datetime | None = None
    arrival_earliest: datetime | None = None
    arrival_latest: datetime | None = None
    seats_left: int | None = None
    first_promise: Promise | None = None
    feedback: Feedback | None = None


class BookedRide(Ride, frozen=True, kw_only=True):
    """A ride that this program has booked.

    token          the secret of the passenger's link
    boarding_code  four digits to type on the onboard screen
    alternatives   for a refused ride, the nearest first
    """

    token: str
    boarding_code: str
    alternatives: tuple[Alternative, ...] = ()


class Pose(msgspec.Struct, frozen=True):
    """Metres east (x) and north (y) of the campus's origin, yaw counter-clockwise from east."""

    x_m: float
    y_m: float
    yaw_rad: float


class VehicleStatus(msgspec.Struct, frozen=True):
    """The newest status of the vehicle."""

    pose_map: Pose
    speed_mps: float
    battery_ratio: float
    doors_open: bool
    visit_id: str
    aboard: tuple[str, ...]


class Visit(msgspec.Struct, frozen=True):
    """A stop or resting place of the vehicle's plan; eta is None while the plan has none."""

    visit_id: str
    kind: Literal["stop", "rest", "temporary"]
    state: Literal["pending", "under_way", "done", "skipped"]
    stop_id: str
    eta: datetime | None


class VehicleCommand(msgspec.Struct, frozen=True):
    """A command on its way; it is repeated until the vehicle answers. detail: why it refused."""

    command_id: str
    vehicle_id: str
    kind: CommandKind
    state: CommandState
    detail: str


class VehicleRecord(msgspec.Struct, frozen=True):
    """Facts that change rarely. held: it stands until it is resumed; in_service: it may get new rides."""

    vehicle_id: str
    name: str
    seats: int
    wheelchair_places: int
    connected: bool
    held: bool
    in_service: bool
    charging: bool
    mode: str


class Vehicle(VehicleRecord, frozen=True):
    """Facts, newest status, plan and newest command; status is None before its first."""

    status: VehicleStatus | None
    plan_version: int
    visits: tuple[Visit, ...]
    last_command: VehicleCommand | None

    def last_visit_to(self, stop_id: str) -> Visit | None:
        """The last visit of the plan to this stop: the one that `send` has added."""
        return next((visit for visit in reversed(self.visits) if visit.stop_id == stop_id), None)


class Closure(msgspec.Struct, frozen=True):
    """A closed road; ends_at None: until it is lifted."""

    closure_id: str
    lane_ids: tuple[str, ...]
    section_ids: tuple[str, ...]
    reason: str
    starts_at: datetime
    ends_at: datetime | None
    made_by: str
    state: str
