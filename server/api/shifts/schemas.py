"""A vehicle's shifts as operators see and set them."""

from datetime import date
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from server.api.service.schemas import ClockTime, clock_of, seconds_of
from server.domain.fleet.shifts import (
    WEEK,
    DutyException,
    Shift,
    Shifts,
)

EXAMPLE: JsonDict = {
    "weekly": [[{"begins": "07:30", "ends": "22:00"}], [], [], [], [], [], []],
    "exceptions": [{"day": "2026-10-01", "shifts": []}],
}


class ShiftModel(BaseModel):
    """Campus local time; one past midnight ends after 24:00."""

    model_config = ConfigDict(extra="forbid")

    begins: ClockTime
    ends: ClockTime


class DutyExceptionModel(BaseModel):
    """A day with other shifts than its weekday; without shifts, a day off."""

    model_config = ConfigDict(extra="forbid")

    day: date = Field(ge=date(2000, 1, 1), le=date(2100, 1, 1))
    shifts: Annotated[list[ShiftModel], Field(max_length=12)] = []


class ShiftsModel(BaseModel):
    """When a vehicle is on duty. Off duty it rests; riders aboard always reach their stops first."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": EXAMPLE})

    weekly: Annotated[
        list[Annotated[list[ShiftModel], Field(max_length=12)]],
        Field(min_length=WEEK, max_length=WEEK, description="For each weekday, Monday first."),
    ]
    exceptions: Annotated[list[DutyExceptionModel], Field(max_length=400)] = []


def shifts_of(body: ShiftsModel) -> Shifts:
    return Shifts(
        tuple(_shifts(day) for day in body.weekly),
        tuple(DutyException(e.day, _shifts(e.shifts)) for e in body.exceptions),
    )


def shifts_model(shifts: Shifts) -> ShiftsModel:
    return ShiftsModel(
        weekly=[_models(day) for day in shifts.weekly],
        exceptions=[DutyExceptionModel(day=e.day, shifts=_models(e.shifts)) for e in shifts.exceptions],
    )


def _shifts(models: list[ShiftModel]) -> tuple[Shift, ...]:
    return tuple(Shift(seconds_of(model.begins), seconds_of(model.ends)) for model in models)


def _models(shifts: tuple[Shift, ...]) -> list[ShiftModel]:
    return [ShiftModel(begins=clock_of(s.begins_s), ends=clock_of(s.ends_s)) for s in shifts]
