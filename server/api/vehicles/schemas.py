"""Vehicles as consoles see them, and as vehicles enrol themselves."""

from datetime import datetime
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from contract.wire.messages import CommandKind
from contract.wire.reasons import FaultCode, FaultSeverity, HoldReason, LocalizationPhase
from server.api.formats import FreeText, Name
from server.domain.fleet.vehicles import Vehicle, VehicleCommand
from server.domain.rules import FleetRules
from server.usecases.ports.views import VehicleView

VEHICLE_EXAMPLE: JsonDict = {
    "vehicle_id": "shuttle-1",
    "name": "Shuttle 1",
    "seats": 6,
    "wheelchair_places": 1,
    "connected": True,
    "held": False,
    "in_service": True,
    "placed": True,
    "hold_ends": None,
    "charging": False,
    "mode": "autonomous",
    "epoch": 7,
    "boot_id": "boot-7a1e",
    "software": "0.1.0",
    "stack": "gem",
    "map_version": "3f0c9a71d2e84b55",
    "enrolled_at": "2026-08-30T06:00:00Z",
}


class VehicleRecord(BaseModel):
    """Facts that change seldom."""

    model_config = ConfigDict(from_attributes=True, json_schema_extra={"example": VEHICLE_EXAMPLE})

    vehicle_id: str
    name: str
    seats: int
    wheelchair_places: int
    connected: bool
    held: bool = Field(description="It stands until an operator resumes it.")
    in_service: bool = Field(description="It may get new rides.")
    placed: bool = Field(description="It holds the sections under its body, so that it can get a route.")
    hold_ends: datetime | None = Field(description="When the server resumes it; null: an operator does.")
    charging: bool = Field(description="It is charging, or on its way to a charger, and not full yet.")
    mode: str
    epoch: int
    boot_id: str
    software: str
    stack: str
    map_version: str
    enrolled_at: datetime


class PoseView(BaseModel):
    """Map frame: metres east (x) and north (y) of the origin, yaw counter-clockwise from east."""

    model_config = ConfigDict(from_attributes=True)

    x_m: float
    y_m: float
    yaw_rad: float


class FaultView(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    code: FaultCode
    severity: FaultSeverity


class StatusView(BaseModel):
    """Its newest status."""

    model_config = ConfigDict(from_attributes=True)

    pose_map: PoseView
    speed_mps: float
    lane_id: str
    s_m: float
    battery_ratio: float
    doors_open: bool
    visit_id: str
    aboard: tuple[str, ...]
    screen: str
    spoken: str
    obstacle_m: float | None
    waiting_for: str
    faults: tuple[FaultView, ...]
    hold_reason: HoldReason | None
    hold_detail: str
    localization: "LocalizationView | None"


class VisitView(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    visit_id: str
    kind: Literal["stop", "rest", "temporary"]
    state: Literal["pending", "under_way", "done", "skipped"]
    stop_id: str
    lane_id: str
    s_m: float
    board: tuple[str, ...]
    alight: tuple[str, ...]
    dwell_s: float
    not_before: datetime | None
    latest: datetime | None
    eta: datetime | None
    why: Literal["", "charge", "demand"] = Field(
        description="A rest to charge, or where riders are expected; empty for the nearest place."
    )


class VehicleDetail(VehicleRecord):
    """Facts, newest status, plan, sections and newest command of one vehicle."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": VEHICLE_EXAMPLE
            | {
                "heard_at": None,
                "status": None,
                "last_command": None,
                "plan_version": 12,
                "visits": [],
                "charged_at": None,
                "order_id": "order-4",
                "revision": 2,
                "order_state": "accepted",
                "order_waits": False,
                "route": ["lane-17", "lane-18"],
                "held_sections": ["lane-17/2"],
                "sections_ahead": ["lane-18/0"],
            }
        }
    )

    heard_at: datetime | None
    status: StatusView | None
    last_command: "CommandView | None"
    plan_version: int
    visits: list[VisitView]
    charged_at: datetime | None = Field(
        description="When it will have charged, if it is at a charger by now; null: it does not charge."
    )
    order_id: str
    revision: int
    order_state: str | None
    order_waits: bool = Field(description="The newest plan waits until its route is safe.")
    route: list[str]
    held_sections: list[str]
    sections_ahead: list[str]


class CommandView(BaseModel):
    """A command to a vehicle; it is repeated until the vehicle answers it."""

    model_config = ConfigDict(
        from_attributes=True,
        json_schema_extra={
            "example": {
                "command_id": "command-4",
                "vehicle_id": "shuttle-1",
                "kind": "hold",
                "text": "",
                "state": "pending",
                "detail": "",
            }
        },
    )

    command_id: str
    vehicle_id: str
    kind: CommandKind
    text: str
    state: Literal["pending", "done", "failed"]
    detail: str = Field(description="The vehicle's reason when it refused, or what came of it.")


class Announcement(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"text": "We wait for a delivery van."}}
    )

    text: FreeText = Field(min_length=1)


class Place(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"lane_id": "lane-17", "s_m": 42.5}}
    )

    lane_id: str = Field(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f]+$")
    s_m: float = Field(ge=0, le=100_000, allow_inf_nan=False)


class NamedPosition(BaseModel):
    """Where a vehicle stands: metres east (x) and north (y) of the origin; yaw as in every pose."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"x_m": 106.2, "y_m": 447.2, "yaw_rad": -0.98}}
    )

    x_m: float = Field(ge=-100_000, le=100_000, allow_inf_nan=False)
    y_m: float = Field(ge=-100_000, le=100_000, allow_inf_nan=False)
    yaw_rad: float = Field(ge=-7, le=7, allow_inf_nan=False)


class LocalizationView(BaseModel):
    """How well the vehicle knows where it is; the deviation is along its worst direction."""

    model_config = ConfigDict(from_attributes=True)

    phase: LocalizationPhase
    position_std_m: float | None
    agreement: float | None = Field(description="Share of the last scan that lies on the map.")


class NewVehicle(BaseModel):
    """The vehicle that a code is made for."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "vehicle_id": "shuttle-1",
                "name": "Shuttle 1",
                "seats": 6,
                "wheelchair_places": 1,
            }
        },
    )

    vehicle_id: Name
    name: FreeText = Field(min_length=1)
    seats: int = Field(6, ge=1, le=200)
    wheelchair_places: int = Field(0, ge=0, le=50)


class CodeView(BaseModel):
    """Type it on the vehicle; it works once."""

    model_config = ConfigDict(
        json_schema_extra={"example": {"vehicle_id": "shuttle-1", "code": "Zk3v7bX0aY5wQ9eR"}}
    )

    vehicle_id: str
    code: str


class Enrolment(BaseModel):
    """A vehicle's request to enrol its key."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "code": "Zk3v7bX0aY5wQ9eR",
                "vehicle_id": "shuttle-1",
                "public_key": "11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo=",
            }
        },
    )

    code: str = Field(min_length=4, max_length=128, pattern=r"^[\x21-\x7e]+$")
    vehicle_id: Name
    public_key: str = Field(max_length=64, description="Ed25519, 32 raw bytes, base64.")


def vehicle_record(vehicle: Vehicle) -> VehicleRecord:
    return VehicleRecord.model_validate(vehicle)


def vehicle_detail(view: VehicleView, rules: FleetRules) -> VehicleDetail:
    facts = vehicle_record(view.vehicle)
    return VehicleDetail(
        **facts.model_dump(),
        heard_at=view.heard_at,
        status=None if view.status is None else StatusView.model_validate(view.status),
        last_command=None if view.last_command is None else command_view(view.last_command),
        plan_version=view.plan.version,
        visits=[VisitView.model_validate(visit) for visit in view.plan.visits],
        charged_at=view.charged_at(rules),
        order_id=view.order_id,
        revision=view.revision,
        order_state=view.order_state,
        order_waits=view.order_waits,
        route=list(view.route),
        held_sections=[section.section_id for section in view.held_sections],
        sections_ahead=list(view.sections_ahead),
    )


def command_view(command: VehicleCommand) -> CommandView:
    return CommandView.model_validate(command)
