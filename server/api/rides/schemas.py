"""Rides as passengers and operators see them."""

from datetime import datetime
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic.config import JsonDict

from server.api.formats import FreeText, Moment, StopId
from server.domain.rides.rides import (
    RideSource,
    RideState,
)

RIDE_EXAMPLE: JsonDict = {
    "ride_id": "ride-5f2c",
    "ride_code": "K7MQ2X",
    "state": "assigned",
    "from_stop": "library",
    "to_stop": "east-gate",
    "party": 2,
    "wheelchairs": 0,
    "earliest": "2026-09-01T08:15:00Z",
    "requested_at": "2026-09-01T08:14:31Z",
    "promise": {
        "pickup_from": "2026-09-01T08:17:00Z",
        "pickup_to": "2026-09-01T08:23:00Z",
        "arrive_by": "2026-09-01T08:34:00Z",
    },
    "vehicle_id": "shuttle-1",
    "vehicle_name": "Shuttle 1",
    "pickup_eta": "2026-09-01T08:18:20Z",
    "pickup_earliest": "2026-09-01T08:17:30Z",
    "pickup_latest": "2026-09-01T08:20:30Z",
    "arrival_eta": "2026-09-01T08:26:05Z",
    "arrival_earliest": None,
    "arrival_latest": None,
    "boarded_at": None,
    "ended_at": None,
    "reason": "",
    "reason_detail": "",
    "promise_broken": False,
    "left_early": False,
    "first_to_stop": None,
    "let_out": False,
    "stranded_by": None,
    "seats_left": 2,
}


class RideRequest(BaseModel):
    """A party's request. Without `earliest` it means now."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"from_stop": "library", "to_stop": "east-gate", "party": 2}},
    )

    from_stop: StopId
    to_stop: StopId
    party: int = Field(1, ge=1, le=1000, description="People travelling, wheelchairs included.")
    wheelchairs: int = Field(0, ge=0, le=1000, description="How many of them need a wheelchair place.")
    earliest: Moment | None = None
    may_walk: bool = Field(
        False,
        description="Other stops within walking distance will do: the answer says from and to which, and the "
        "promised window allows for the walk.",
    )


class DestinationRequest(BaseModel):
    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"to_stop": "east-gate"}})

    to_stop: StopId


class HelpRequest(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"text": "The door does not open."}}
    )

    text: FreeText = ""


class FeedbackRequest(BaseModel):
    """At least one of both."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"rating": 5, "lost_property": "A blue umbrella"}}
    )

    rating: int | None = Field(None, ge=1, le=5, description="1 (bad) to 5 (good).")
    lost_property: FreeText = Field("", description="What was left in the shuttle, and how to be reached.")

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.rating is None and not self.lost_property:
            raise ValueError("give a rating, or say what was left in the shuttle")
        return self


class FeedbackView(BaseModel):
    """What the passenger said after the ride. It is erased with the rider's data."""

    rating: int | None
    lost_property: str = Field(description="Empty for developers: it is the passenger's.")
    made_at: datetime


class PromiseView(BaseModel):
    """The party is picked up within [pickup_from, pickup_to] and is there by arrive_by."""

    pickup_from: datetime
    pickup_to: datetime
    arrive_by: datetime


class RideView(BaseModel):
    """A ride as everyone with its code may see it.

    The promise changes only with the destination; pickup_eta and arrival_eta are the times of the present
    plan. A refused ride has no promise, and `reason` names the rule that binds.
    """

    model_config = ConfigDict(json_schema_extra={"example": RIDE_EXAMPLE})

    ride_id: str
    ride_code: str = Field(description="Six characters to be said aloud.")
    state: RideState
    from_stop: str
    to_stop: str
    party: int
    wheelchairs: int
    earliest: datetime
    requested_at: datetime
    promise: PromiseView | None
    vehicle_id: str | None
    vehicle_name: str = Field("", description="Of the shuttle that has or had the ride; empty for none.")
    pickup_eta: datetime | None
    pickup_earliest: datetime | None = Field(
        None,
        description="The shuttle comes between this and pickup_latest in 9 of 10 cases. Null while no time "
        "can be promised: the party is not waiting, or its shuttle stands or is out of reach.",
    )
    pickup_latest: datetime | None = None
    arrival_eta: datetime | None
    arrival_earliest: datetime | None = Field(
        None,
        description="The party arrives between this and arrival_latest in 9 of 10 cases, from the booking "
        "on. Null while it has no shuttle or gets on, and while its shuttle stands or is out of reach.",
    )
    arrival_latest: datetime | None = None
    boarded_at: datetime | None
    ended_at: datetime | None
    reason: str
    reason_detail: str
    promise_broken: bool
    first_promise: PromiseView | None = Field(
        None, description="The first promise, if it could not be kept; `promise` is the present one."
    )
    left_early: bool
    first_to_stop: str | None = Field(description="Where it was booked to, when the destination has changed.")
    let_out: bool = Field(description="The party asked to get off as soon as possible: to_stop is where.")
    stranded_by: str | None = Field(
        description="The shuttle that carried the party and cannot go on: another one comes to from_stop."
    )
    seats_left: int | None = Field(
        None,
        description="Free seats of the shuttle beside the party, on the fullest part of the ride as planned.",
    )


class AlternativeView(BaseModel):
    """What would have been accepted when a ride was refused: one ride, or two with a part of the party each.

    Nothing is reserved: book it again, with these stops and `earliest` at the pickup.
    """

    kind: Literal["later", "other_stops", "split_party"]
    from_stop: str
    to_stop: str
    parties: list[int] = Field(description="People in each ride.")
    walk_s: float = Field(description="Additional walking compared with the requested stops, in seconds.")
    pickup_at: list[datetime] = Field(description="Planned pickup of each ride.")
    arrival_at: list[datetime]


class OfferView(BaseModel):
    """What a booking would get now. Nothing is reserved: book to get it."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "is_free": True,
                "rule": "",
                "pickup_at": "2026-09-01T08:18:20Z",
                "arrival_at": "2026-09-01T08:26:05Z",
            }
        }
    )

    is_free: bool
    rule: str = Field(description="The rule that binds, empty where a shuttle is free.")
    pickup_at: datetime | None = Field(description="As planned; null where no shuttle is free.")
    arrival_at: datetime | None


class RideTicket(RideView):
    """A ride as its passenger sees it."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": RIDE_EXAMPLE
            | {"token": "q3Jv0X2mQp7sT4uYb1cD9w", "boarding_code": "4821", "alternatives": []}
        }
    )

    token: str = Field(description="The secret of the passenger's link; it allows to cancel the ride.")
    boarding_code: str = Field(description="Four digits to type on the onboard screen.")
    alternatives: list[AlternativeView] = Field(description="For a refused ride, the nearest first.")
    feedback: FeedbackView | None = Field(None, description="What the passenger has said after the ride.")


class RideRecord(RideView):
    """A ride as operators and developers see it."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": RIDE_EXAMPLE | {"source": "passenger", "boarding_code": "4821", "series_id": None}
        }
    )

    source: RideSource
    boarding_code: str = Field(description="Empty for developers: it is the passenger's.")
    series_id: str | None = Field(description="The recurring booking that it is a day of.")
    feedback: FeedbackView | None = Field(None, description="What the passenger has said after the ride.")


class QuoteView(BaseModel):
    """A ride as one shuttle would serve it."""

    vehicle_id: str
    extra_cost_s: float = Field(description="Weighted seconds of driving, waiting and riding that it adds.")
    pickup_at: datetime
    arrival_at: datetime


class DecisionView(BaseModel):
    """Why a ride got its shuttle, or none."""

    made_at: datetime
    rule: str = Field(description="The rule that binds, empty for a ride that got a shuttle.")
    best: QuoteView | None
    runner_up: QuoteView | None = Field(description="The best that any other shuttle offered.")
    alternatives: list[AlternativeView]
    vehicles: int = Field(description="Shuttles that were considered.")


class RideEventView(BaseModel):
    """Something that has happened to a ride."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "happened_at": "2026-09-01T08:14:31Z",
                "name": "ride.booked",
                "by": "passenger",
                "detail": "library to east-gate, party of 2",
            }
        }
    )

    happened_at: datetime
    name: str
    by: str = Field(description="A vehicle, an operator, `passenger`, `developer`, or empty for the server.")
    detail: str


class RideDelayView(BaseModel):
    """Another ride of the same shuttle, and how much later it is because of this one."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {"ride_id": "ride-77aa", "ride_code": "M4PX9T", "pickup_s": 0.0, "arrival_s": 95.0}
        }
    )

    ride_id: str
    ride_code: str
    pickup_s: float
    arrival_s: float


class CallerBooking(BaseModel):
    """The answer to a booking by telephone."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "ride": RIDE_EXAMPLE | {"source": "operator", "boarding_code": "4821", "series_id": None},
                "alternatives": [],
            }
        }
    )

    ride: RideRecord
    alternatives: list[AlternativeView] = Field(description="For a refused ride, the nearest first.")


class TapView(BaseModel):
    """A tap on its way to the shuttle, which accepts it only while it stands with doors open."""

    model_config = ConfigDict(
        json_schema_extra={"example": {"tap_id": "tap-8", "kind": "board", "state": "pending", "reason": ""}}
    )

    tap_id: str
    kind: Literal["board", "alight"]
    state: Literal["pending", "accepted", "refused"]
    reason: str


class HelpAnswer(BaseModel):
    """An operator sees the call on top of all incidents."""

    model_config = ConfigDict(json_schema_extra={"example": {"incident_id": "incident-19"}})

    incident_id: str
