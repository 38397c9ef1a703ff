"""What a live subscription yields. Times are milliseconds since the Unix epoch, 0 for "never"."""

from typing import Any, Literal

import msgspec

Topic = Literal["vehicles", "rides", "events"]


class LivePose(msgspec.Struct, frozen=True, array_like=True):
    """Metres east (x) and north (y) of the campus's origin, yaw counter-clockwise from east."""

    x_m: float
    y_m: float
    yaw_rad: float


class LiveFacts(msgspec.Struct, frozen=True):
    name: str
    seats: int
    connected: bool
    held: bool
    in_service: bool
    charging: bool
    mode: str


class LiveVisit(msgspec.Struct, frozen=True):
    """A visit that is not done."""

    visit_id: str
    kind: str
    state: Literal["pending", "under_way", "done", "skipped"]
    stop_id: str
    eta_ms: int


class LiveTask(msgspec.Struct, frozen=True):
    """next_stop is "" if the vehicle only drives to a resting place."""

    next_stop: str
    people_aboard: int
    at_charger: bool
    visits: tuple[LiveVisit, ...]


class LiveStatus(msgspec.Struct, frozen=True):
    pose_map: LivePose
    speed_mps: float
    mode: str
    battery_ratio: float
    doors_open: bool
    visit_id: str
    aboard: tuple[str, ...]


class LiveVehicle(msgspec.Struct, frozen=True):
    """status: None before the first; heard_ms: when the server received it."""

    vehicle_id: str
    facts: LiveFacts
    task: LiveTask
    status: LiveStatus | None
    heard_ms: int

    def visit(self, visit_id: str) -> LiveVisit | None:
        """The visit of this id, None once it is done or no longer planned."""
        return next((visit for visit in self.task.visits if visit.visit_id == visit_id), None)


class LiveRide(msgspec.Struct, frozen=True):
    """A ride that has not ended, or has ended a moment ago. seats_left: None while not known."""

    ride_id: str
    ride_code: str
    state: str
    from_stop: str
    to_stop: str
    party: int
    vehicle_id: str
    pickup_eta_ms: int
    arrival_eta_ms: int
    reason: str
    pickup_earliest_ms: int = 0
    pickup_latest_ms: int = 0
    arrival_earliest_ms: int = 0
    arrival_latest_ms: int = 0
    seats_left: int | None = None


class VehiclesUpdate(msgspec.Struct, frozen=True):
    """snapshot: `vehicles` are all there are; otherwise those that changed. gone: ids of those gone."""

    at_ms: int
    snapshot: bool
    vehicles: tuple[LiveVehicle, ...]
    gone: tuple[str, ...] = ()


class RidesUpdate(msgspec.Struct, frozen=True):
    """snapshot: `rides` are all there are; otherwise those that changed. gone: ids of those gone."""

    at_ms: int
    snapshot: bool
    rides: tuple[LiveRide, ...]
    gone: tuple[str, ...] = ()


class EventUpdate(msgspec.Struct, frozen=True):
    """An event as the vehicle reported it. Events that happen without a connection are not repeated."""

    vehicle_id: str
    boot_id: str
    sequence: int
    body: dict[str, Any]


Update = VehiclesUpdate | RidesUpdate | EventUpdate
UPDATES: dict[str, type[VehiclesUpdate] | type[RidesUpdate] | type[EventUpdate]] = {
    "vehicles": VehiclesUpdate,
    "rides": RidesUpdate,
    "events": EventUpdate,
}
