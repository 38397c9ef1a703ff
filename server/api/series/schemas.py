"""Recurring bookings as passengers and operators see them."""

from datetime import date, datetime
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints
from pydantic.config import JsonDict

from server.api.formats import StopId
from server.api.rides.schemas import RideTicket
from server.api.rides.views import ride_ticket
from server.api.service.schemas import Weekday
from server.domain.rides.rides import RideSource
from server.domain.rides.series import (
    BookSeries,
    OccurrenceState,
    Series,
    SeriesState,
)
from server.usecases.rides.series import OccurrenceView

LocalTime = Annotated[
    str, StringConstraints(pattern=r"^([01][0-9]|2[0-3]):[0-5][0-9]$"), Field(examples=["08:10"])
]
# Beyond these a calendar's arithmetic would leave the range of dates.
SeriesDay = Annotated[date, Field(ge=date(2000, 1, 1), le=date(2100, 1, 1), examples=["2026-10-01"])]

SERIES_EXAMPLE: JsonDict = {
    "series_id": "series-7b21",
    "state": "active",
    "from_stop": "library",
    "to_stop": "east-gate",
    "party": 1,
    "wheelchairs": 0,
    "weekdays": [0, 1, 2, 3, 4],
    "leave": "08:10",
    "timezone": "Asia/Shanghai",
    "starts_on": "2026-09-01",
    "ends_on": "2026-12-18",
    "made_at": "2026-08-30T02:11:00Z",
    "ended_at": None,
}


class SeriesRequest(BaseModel):
    """The same ride on certain weekdays, at one campus local time, until a last day; not on holidays."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "from_stop": "library",
                "to_stop": "east-gate",
                "weekdays": [0, 1, 2, 3, 4],
                "leave": "08:10",
                "ends_on": "2026-12-18",
            }
        },
    )

    from_stop: StopId
    to_stop: StopId
    weekdays: list[Weekday] = Field(min_length=1, max_length=7)
    leave: LocalTime = Field(description="Earliest pickup, campus local time whatever the clocks do.")
    ends_on: SeriesDay = Field(description="Last day, included.")
    starts_on: SeriesDay | None = Field(None, description="First day; today if left out.")
    party: int = Field(1, ge=1, le=1000, description="People travelling, wheelchairs included.")
    wheelchairs: int = Field(0, ge=0, le=1000, description="How many of them need a wheelchair place.")


class DayView(BaseModel):
    """One day of it. planned: too far ahead; trying: no vehicle can take it yet, `reason` says why, and it is
    tried again until its time has come."""

    day: date
    leave_at: datetime
    state: OccurrenceState
    reason: str
    reason_detail: str
    ride: RideTicket | None


class SeriesView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": SERIES_EXAMPLE})

    series_id: str
    state: SeriesState
    from_stop: str
    to_stop: str
    party: int
    wheelchairs: int
    weekdays: list[int]
    leave: str
    timezone: str
    starts_on: date
    ends_on: date
    made_at: datetime
    ended_at: datetime | None


class SeriesRecord(SeriesView):
    """A recurring booking as an operator sees it."""

    model_config = ConfigDict(json_schema_extra={"example": SERIES_EXAMPLE | {"source": "passenger"}})

    source: Literal["passenger", "operator", "developer"]


class SeriesTicket(SeriesView):
    """A recurring booking as its passenger sees it."""

    model_config = ConfigDict(
        json_schema_extra={"example": SERIES_EXAMPLE | {"token": "q3Jv0X2mQp7sT4uYb1cD9w", "days": []}}
    )

    token: str = Field(description="The secret of the booking's link; it allows to cancel it.")
    days: list[DayView]


class SeriesErasure(BaseModel):
    """What was erased with a recurring booking."""

    model_config = ConfigDict(json_schema_extra={"example": {"rides": 12}})

    rides: int = Field(description="Rides of its days that name nobody now.")


def series_request(request: SeriesRequest, idempotency_key: str | None, source: RideSource) -> BookSeries:
    hours, minutes = request.leave.split(":")
    return BookSeries(
        from_stop=request.from_stop,
        to_stop=request.to_stop,
        weekdays=tuple(request.weekdays),
        leave_s=int(hours) * 3600 + int(minutes) * 60,
        ends_on=request.ends_on,
        starts_on=request.starts_on,
        party=request.party,
        wheelchairs=request.wheelchairs,
        idempotency_key=idempotency_key,
        source=source,
    )


def series_record(series: Series, timezone: str) -> SeriesRecord:
    return SeriesRecord.model_validate(_fields(series, timezone) | {"source": series.source})


def series_ticket(
    series: Series, token: str, timezone: str, days: tuple[OccurrenceView, ...]
) -> SeriesTicket:
    more = {"token": token, "days": [_day(view) for view in days]}
    return SeriesTicket.model_validate(_fields(series, timezone) | more)


def _day(view: OccurrenceView) -> DayView:
    occurrence = view.occurrence
    return DayView(
        day=occurrence.day,
        leave_at=occurrence.leave_at,
        state=occurrence.state,
        reason=occurrence.reason,
        reason_detail=occurrence.reason_detail,
        ride=None if view.ride is None else ride_ticket(view.ride, view.secrets, view.outlook),
    )


def _fields(series: Series, timezone: str) -> dict[str, object]:
    return {
        "series_id": series.series_id,
        "state": series.state,
        "from_stop": series.from_stop,
        "to_stop": series.to_stop,
        "party": series.party,
        "wheelchairs": series.wheelchairs,
        "weekdays": list(series.weekdays),
        "leave": f"{series.leave_s // 3600:02d}:{series.leave_s % 3600 // 60:02d}",
        "timezone": timezone,
        "starts_on": series.starts_on,
        "ends_on": series.ends_on,
        "made_at": series.made_at,
        "ended_at": series.ended_at,
    }
