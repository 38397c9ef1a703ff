"""The server's answers and notifications: vehicles, stops, rides."""

from typing import Any

import msgspec


class Pose(msgspec.Struct, frozen=True, array_like=True):
    """Map frame: metres east (x) and north (y) of the campus's origin, REP-103 yaw."""

    x_m: float
    y_m: float
    yaw_rad: float


class VehicleFacts(msgspec.Struct, frozen=True):
    """Facts that change rarely. held: it stands until it is resumed; in_service: it may get new rides."""

    name: str
    seats: int
    wheelchair_places: int
    connected: bool
    held: bool
    in_service: bool
    charging: bool
    mode: str


class VehicleTask(msgspec.Struct, frozen=True):
    """The vehicle's task; next_stop is "" if it only drives to a resting place."""

    next_stop: str
    people_aboard: int
    at_charger: bool


class VehicleStatus(msgspec.Struct, frozen=True):
    """The newest status of the vehicle."""

    pose_map: Pose
    speed_mps: float
    mode: str
    battery_ratio: float
    doors_open: bool
    visit_id: str
    aboard: tuple[str, ...]


class Shuttle(msgspec.Struct, frozen=True):
    """A vehicle as the live scene shows it.

    status    None before its first
    heard_ms  when the server received that status, milliseconds since the Unix epoch
    """

    vehicle_id: str
    facts: VehicleFacts
    task: VehicleTask
    status: VehicleStatus | None
    heard_ms: int


class Stop(msgspec.Struct, frozen=True):
    stop_id: str
    name: str
    name_en: str
    x_m: float
    y_m: float


class RideSummary(msgspec.Struct, frozen=True):
    ride_id: str
    ride_code: str
    state: str
    from_stop: str
    to_stop: str
    party: int
    vehicle_id: str


class SentVisit(msgspec.Struct, frozen=True):
    """The visit that the vehicle will make; eta is None while the plan has none."""

    visit_id: str
    plan_version: int
    eta: str | None


class CommandReceipt(msgspec.Struct, frozen=True):
    command_id: str
    state: str


class Notification(msgspec.Struct, frozen=True):
    """A message of a subscribed topic; docs/server/api.md lists the fields of `params` for each topic."""

    topic: str
    params: dict[str, Any]
