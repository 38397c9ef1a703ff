"""Operators' interventions with a vehicle, and their effects on rides and departures."""

from datetime import datetime
from typing import Annotated, Literal

from fastapi import Query
from pydantic import BaseModel, ConfigDict, Field

from server.domain.rides.effects import (
    DepartureEffect,
    Effects,
    Intervention,
    RideEffect,
)

HOLD_S_MAX = 24 * 3600.0
_Seconds = Annotated[float | None, Field(ge=10.0, le=HOLD_S_MAX, allow_inf_nan=False)]
HoldSeconds = Annotated[
    float | None,
    Query(ge=10.0, le=HOLD_S_MAX, allow_inf_nan=False, description="Resumed by the server then."),
]
_Id = Annotated[str, Field(max_length=64, pattern=r"^[^\x00-\x1f]*$")]


class Reassignment(BaseModel):
    """All rides that wait for the vehicle, or one of them; to any other vehicles, or to a named one."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"ride_id": "ride-9", "to_vehicle_id": "shuttle-2"}}
    )

    ride_id: _Id = Field("", description="Empty for all waiting rides.")
    to_vehicle_id: _Id = Field("", description="Empty for any vehicle that can take them.")


class InterventionRequest(Reassignment):
    """An intervention to be previewed."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"kind": "hold", "for_s": 600.0}})

    kind: Literal["hold", "recall", "reassign"]
    for_s: _Seconds = Field(None, description="How long a hold lasts; null: until resumed.")


class RideEffectView(BaseModel):
    """A ride that the intervention changes."""

    ride_id: str
    ride_code: str
    state: str
    from_stop: str
    to_stop: str
    party: int
    vehicle_before: str | None
    vehicle_after: str | None = Field(description="Null: no vehicle.")
    pickup_before: datetime | None
    pickup_after: datetime | None
    pickup_later_s: float | None = Field(description="Negative: earlier; null: not known.")
    arrival_before: datetime | None
    arrival_after: datetime | None
    arrival_later_s: float | None
    breaks: bool = Field(description="Its promise cannot be kept any more.")
    waits: bool = Field(description="Its vehicle stands until an operator resumes it.")
    ends: bool = Field(description="The ride ends: no vehicle can serve it.")
    to_stop_after: str = Field(description="Where the party gets off; another stop if it is let out early.")
    postponed_to: datetime | None = Field(description="The new promised pickup, when the road is open again.")


class DepartureEffectView(BaseModel):
    """A timetable departure that changes its vehicle or its lateness."""

    departure_id: str
    vehicle_before: str | None
    vehicle_after: str | None
    late_before_s: float
    late_after_s: float
    waits: bool


class EffectsView(BaseModel):
    """The changed rides and departures; unchanged ones are left out."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "rides": [
                    {
                        "ride_id": "ride-9",
                        "ride_code": "K7M2QX",
                        "state": "assigned",
                        "from_stop": "library",
                        "to_stop": "gate",
                        "party": 2,
                        "vehicle_before": "shuttle-1",
                        "vehicle_after": "shuttle-2",
                        "pickup_before": "2026-09-01T08:20:00Z",
                        "pickup_after": "2026-09-01T08:23:10Z",
                        "pickup_later_s": 190.0,
                        "arrival_before": "2026-09-01T08:31:00Z",
                        "arrival_after": "2026-09-01T08:34:10Z",
                        "arrival_later_s": 190.0,
                        "breaks": False,
                        "waits": False,
                        "ends": False,
                        "to_stop_after": "gate",
                        "postponed_to": None,
                    }
                ],
                "departures": [],
            }
        }
    )

    rides: list[RideEffectView]
    departures: list[DepartureEffectView]


def intervention(request: InterventionRequest) -> Intervention:
    return Intervention(request.kind, request.for_s, request.ride_id, request.to_vehicle_id)


def effects_view(effects: Effects) -> EffectsView:
    return EffectsView(
        rides=[_ride(effect) for effect in effects.rides],
        departures=[_departure(effect) for effect in effects.departures],
    )


def _ride(effect: RideEffect) -> RideEffectView:
    return RideEffectView(
        ride_id=effect.ride_id,
        ride_code=effect.ride_code,
        state=str(effect.state),
        from_stop=effect.from_stop,
        to_stop=effect.to_stop,
        party=effect.party,
        vehicle_before=effect.vehicle_before,
        vehicle_after=effect.vehicle_after,
        pickup_before=effect.pickup_before,
        pickup_after=effect.pickup_after,
        pickup_later_s=effect.pickup_later_s,
        arrival_before=effect.arrival_before,
        arrival_after=effect.arrival_after,
        arrival_later_s=effect.arrival_later_s,
        breaks=effect.breaks,
        waits=effect.waits,
        ends=effect.ends,
        to_stop_after=effect.to_stop_after,
        postponed_to=effect.postponed_to,
    )


def _departure(effect: DepartureEffect) -> DepartureEffectView:
    return DepartureEffectView(
        departure_id=effect.departure_id,
        vehicle_before=effect.vehicle_before,
        vehicle_after=effect.vehicle_after,
        late_before_s=effect.late_before_s,
        late_after_s=effect.late_after_s,
        waits=effect.waits,
    )
