"""What the server tells scripts: vehicles, stops, rides, answers and notifications."""

from typing import Any

import msgspec


class Shuttle(msgspec.Struct, frozen=True):
    """A vehicle as the live scene shows it; metres in the map frame, REP-103 yaw."""

    vehicle_id: str
    name: str
    seats: int
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    located: bool
    mode: str
    connected: bool
    held: bool
    in_service: bool
    battery_ratio: float
    doors_open: bool
    next_stop: str
    visit_id: str
    people_aboard: int


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
