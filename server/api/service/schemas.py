"""The service's days and hours, and a day's timetable, as pages and operators see them."""

from collections.abc import Mapping, Sequence
from datetime import date, datetime
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints
from pydantic.config import JsonDict

from server.api.formats import NAME_PATTERN, FreeText, Name
from server.domain.service.service import (
    Hours,
    ServiceException,
    ServicePattern,
    Span,
)
from server.domain.service.timetable import DepartureState
from server.usecases.record.calendars import ServiceDay

# A service's times may run past midnight, as in GTFS: 25:30 is half past one on the next day.
ClockTime = Annotated[
    str, StringConstraints(pattern=r"^([0-2][0-9]|3[0-5]):[0-5][0-9]$|^36:00$"), Field(examples=["08:00"])
]
Weekday = Annotated[int, Field(ge=0, le=6, description="0 is Monday.")]

PATTERN_EXAMPLE: JsonDict = {
    "name": "Term, working days",
    "weekdays": [0, 1, 2, 3, 4],
    "starts_on": "2026-09-01",
    "ends_on": "2027-01-15",
    "hours": [{"opens": "07:30", "closes": "22:00"}],
}


class HoursModel(BaseModel):
    """Campus local time; closing after 24:00 is on the next day."""

    model_config = ConfigDict(extra="forbid")

    opens: ClockTime
    closes: ClockTime


class PatternBody(BaseModel):
    """The days on which a service runs (calendar.txt of GTFS), and when rides can be booked on them."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": PATTERN_EXAMPLE})

    name: Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=200)]
    weekdays: list[Weekday] = Field(max_length=7)
    starts_on: date | None = Field(None, description="First day; null: no limit.")
    ends_on: date | None = Field(None, description="Last day, included; null: until further notice.")
    hours: list[HoursModel] = Field(
        [], max_length=12, description="When rides can be booked; empty for a service of trips only."
    )


class PatternView(PatternBody):
    model_config = ConfigDict(
        json_schema_extra={"example": PATTERN_EXAMPLE | {"service_id": "term", "trips": 13}}
    )

    service_id: str
    starts_on: date | None
    ends_on: date | None
    hours: list[HoursModel]
    trips: int = Field(description="How many trips of the timetable run by it.")


class ExceptionBody(BaseModel):
    """One day that differs (calendar_dates.txt of GTFS)."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"service_id": "", "runs": False, "note": "National Day"}},
    )

    service_id: Annotated[str, StringConstraints(pattern=f"^$|{NAME_PATTERN}")] = Field(
        "", description="Which service differs; empty: the whole campus, a holiday."
    )
    runs: bool = False
    note: FreeText = ""


class ExceptionView(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "day": "2026-10-01",
                "service_id": "",
                "runs": False,
                "note": "National Day",
                "made_by": "operator",
            }
        }
    )

    day: date
    service_id: str
    runs: bool
    note: str
    made_by: str


class ServiceView(BaseModel):
    """The days and hours at which the campus runs."""

    timezone: str
    patterns: list[PatternView]
    exceptions: list[ExceptionView] = Field(description="By day, from yesterday on.")
    rides_outside: int = Field(
        description="Promised rides that begin when the campus does not run: kept unless they are cancelled."
    )


class CallView(BaseModel):
    stop_id: str
    leave_at: datetime
    is_last: bool = Field(description="No later trip of the day leaves this stop.")
    seats_left: int | None = Field(
        None,
        description="Free seats when the shuttle leaves, as planned; null until the trip has one, and "
        "afterwards.",
    )


class TripView(BaseModel):
    trip_id: str
    service_id: str
    calls: list[CallView]
    is_last_run: bool = Field(description="The last trip of the day to be under way.")
    state: DepartureState
    vehicle_id: str | None


class SpanView(BaseModel):
    opens_at: datetime
    closes_at: datetime


class TimetableDay(BaseModel):
    """What runs on one local day."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "day": "2026-09-01",
                "timezone": "Asia/Shanghai",
                "holiday": None,
                "hours": [{"opens_at": "2026-09-01T00:00:00Z", "closes_at": "2026-09-01T11:00:00Z"}],
                "trips": [
                    {
                        "trip_id": "evening-3",
                        "service_id": "daily",
                        "calls": [
                            {"stop_id": "NN7", "leave_at": "2026-09-01T10:10:00Z", "is_last": True},
                            {"stop_id": "C1", "leave_at": "2026-09-01T10:43:00Z", "is_last": True},
                        ],
                        "is_last_run": True,
                        "state": "planned",
                        "vehicle_id": None,
                    }
                ],
            }
        }
    )

    day: date
    timezone: str
    holiday: str | None = Field(description="The holiday's name, or null on an ordinary day.")
    hours: list[SpanView] = Field(description="When rides can be booked: spans that begin on this day.")
    trips: list[TripView]


def pattern_of(campus_id: str, service_id: Name, body: PatternBody) -> ServicePattern:
    return ServicePattern(
        campus_id,
        service_id,
        body.name,
        tuple(sorted(set(body.weekdays))),
        body.starts_on,
        body.ends_on,
        tuple(Hours(seconds_of(hours.opens), seconds_of(hours.closes)) for hours in body.hours),
    )


def pattern_view(pattern: ServicePattern, trips: int) -> PatternView:
    return PatternView(
        service_id=pattern.service_id,
        name=pattern.name,
        weekdays=list(pattern.weekdays),
        starts_on=pattern.starts_on,
        ends_on=pattern.ends_on,
        hours=[HoursModel(opens=clock_of(h.opens_s), closes=clock_of(h.closes_s)) for h in pattern.hours],
        trips=trips,
    )


def exception_view(exception: ServiceException) -> ExceptionView:
    return ExceptionView(
        day=exception.day,
        service_id=exception.service_id,
        runs=exception.runs,
        note=exception.note,
        made_by=exception.made_by,
    )


def timetable_day(
    shown: ServiceDay,
    timezone: str,
    services: dict[str, str],
    seats_left: Mapping[str, Sequence[int | None]],
) -> TimetableDay:
    """services: trip -> its service. seats_left: departure -> free seats when it leaves each call."""
    last = shown.last_run
    trips = [
        TripView(
            trip_id=departure.trip_id,
            service_id=services.get(departure.trip_id, ""),
            calls=[
                CallView(
                    stop_id=call.stop_id,
                    leave_at=call.leave_at,
                    is_last=shown.last_calls[call.stop_id] == call.leave_at,
                    seats_left=free,
                )
                for call, free in zip(departure.calls, seats_left[departure.departure_id], strict=True)
            ],
            is_last_run=last is departure,
            state=departure.state,
            vehicle_id=departure.vehicle_id,
        )
        for departure in shown.departures
    ]
    holiday = shown.holiday
    return TimetableDay(
        day=shown.day,
        timezone=timezone,
        holiday=None if holiday is None else holiday.note,
        hours=[_span(span) for span in shown.spans],
        trips=trips,
    )


def _span(span: Span) -> SpanView:
    return SpanView(opens_at=span[0], closes_at=span[1])


def seconds_of(clock_time: str) -> int:
    """After local midnight."""
    hours, minutes = clock_time.split(":")
    return int(hours) * 3600 + int(minutes) * 60


def clock_of(second: int) -> str:
    """ "08:00", counted from local midnight."""
    return f"{second // 3600:02d}:{second % 3600 // 60:02d}"
