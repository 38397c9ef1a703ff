"""The timetable for operators: read, tried, saved by revision, and its earlier versions."""

import math
from datetime import datetime
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Path
from pydantic import BaseModel, ConfigDict, Field, StringConstraints
from pydantic.config import JsonDict

from contract.roads.model import TimetableTrip
from server.api.commands import ServiceCommand
from server.api.formats import NAME_PATTERN, FreeText, StopId
from server.api.problems import problems
from server.api.security.access import OPERATOR_REFUSALS, READER_REFUSALS, Actor, Reader, changing
from server.api.security.permissions import RUN_SERVICE
from server.api.services import InjectedServices
from server.domain.errors import CampusUnknown, TimetableChanged, TimetableInvalid, TimetableUnknown
from server.domain.service.timetable import Departure
from server.domain.service.trips import (
    CALLS_MAX,
    TRIPS_MAX,
    TightLeg,
    Timetable,
    TimetableVersion,
    unserved_trips,
)
from server.usecases.fleet import timetables
from server.usecases.fleet.timetables import TimetableEffect
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import timetable_of
from server.usecases.record.dry_run import roll_back

router = APIRouter(prefix="/service/trips", tags=["service"])

# All trips of a campus.
TIMETABLE_BYTES_MAX = 2 << 20
VERSIONS_SHOWN = 50
Revision = Annotated[
    int, Header(alias="If-Match", ge=0, description="The revision that you have seen.", examples=[4])
]
OfRevision = Annotated[int, Path(ge=0, le=2**31, examples=[3])]
LeaveTime = Annotated[
    str,
    StringConstraints(pattern=r"^([0-2][0-9]|3[0-5]):[0-5][0-9](:[0-5][0-9])?$|^36:00(:00)?$"),
    Field(examples=["08:00"]),
]
TRIP_EXAMPLE: JsonDict = {
    "trip_id": "morning-1",
    "service_id": "term",
    "calls": [{"stop_id": "library", "leaves": "08:00"}, {"stop_id": "east-gate", "leaves": "08:12"}],
}


class TripCall(BaseModel):
    """Campus local time; after 24:00 is on the next day."""

    model_config = ConfigDict(extra="forbid")

    stop_id: StopId
    leaves: LeaveTime


class Trip(BaseModel):
    """A scheduled run on the days of its service."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": TRIP_EXAMPLE})

    trip_id: Annotated[str, StringConstraints(pattern=NAME_PATTERN)]
    service_id: Annotated[str, StringConstraints(pattern=f"^$|{NAME_PATTERN}")] = Field(
        "", description="Whose calendar says on which days it runs; empty: every day but holidays."
    )
    calls: list[TripCall] = Field(min_length=2, max_length=CALLS_MAX)


class TimetableBody(BaseModel):
    """All trips: a trip that is left out is removed."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"trips": [TRIP_EXAMPLE], "note": "Earlier buses"}}
    )

    trips: list[Trip] = Field(max_length=TRIPS_MAX)
    note: FreeText = ""


class VersionView(BaseModel):
    revision: int
    trips: int
    made_by: str
    made_at: datetime
    note: str


class UnservedTripView(BaseModel):
    trip_id: str
    missing_stops: list[str]


class TightLegView(BaseModel):
    """A leg of a trip that takes longer than the trip gives it."""

    trip_id: str
    from_stop: str
    to_stop: str
    leaves: LeaveTime = Field(description="At the first of the two stops.")
    given_s: int
    needed_s: int | None = Field(
        description="Driving on an empty campus at that hour, and the stop at the second one unless the trip "
        "ends there. null: no road leads there."
    )


class TimetableView(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "revision": 0,
                "trips": [TRIP_EXAMPLE],
                "made_by": "",
                "made_at": None,
                "note": "",
                "versions": [],
                "unserved": [{"trip_id": "morning-2", "missing_stops": ["old-gate"]}],
                "tight_legs": [],
            }
        }
    )

    revision: int = Field(description="0: the map's own timetable, which no operator has changed.")
    trips: list[Trip]
    made_by: str
    made_at: datetime | None
    note: str
    versions: list[VersionView] = Field(description="The newest first; they can be read and saved again.")
    unserved: list[UnservedTripView] = Field(
        description="Trips that do not run: the map in force lacks some of their stops."
    )
    tight_legs: list[TightLegView] = Field(
        description="Legs that take longer than their trips give them: shuttles are late there."
    )


class AffectedDeparture(BaseModel):
    departure_id: str
    leave_at: datetime
    vehicle_id: str | None


class TimetableEffectView(BaseModel):
    """What a version changes."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "added": ["morning-2"],
                "removed": [],
                "changed": ["morning-1"],
                "withdrawn": [],
                "kept": [],
                "tight_legs": [
                    {
                        "trip_id": "morning-1",
                        "from_stop": "library",
                        "to_stop": "east-gate",
                        "leaves": "08:00",
                        "given_s": 120,
                        "needed_s": 214,
                    }
                ],
            }
        }
    )

    added: list[str]
    removed: list[str]
    changed: list[str]
    withdrawn: list[AffectedDeparture] = Field(
        description="Departures that are taken back; of a changed trip, they are entered with the new times."
    )
    kept: list[AffectedDeparture] = Field(description="Departures that have begun: they run as they were.")
    tight_legs: list[TightLegView] = Field(
        description="Legs that cannot be driven in their times. They do not keep it from being published."
    )


@router.get("", operation_id="get_service_trips", responses=problems(CampusUnknown, *READER_REFUSALS))
async def get_service_trips(services: InjectedServices, _: Reader) -> TimetableView:
    """The timetable in force, and its versions."""
    return await services.transactions.read(lambda uow: _view(uow, timetable_of(uow)))


@router.get(
    "/{revision}",
    operation_id="get_timetable_version",
    responses=problems(TimetableUnknown, CampusUnknown, *READER_REFUSALS),
)
async def get_timetable_version(revision: OfRevision, services: InjectedServices, _: Reader) -> TimetableView:
    """An earlier version: save its trips again to return to it. 0 is the map's own timetable."""
    return await services.transactions.read(lambda uow: _view(uow, timetables.version_of(uow, revision)))


@router.put(
    "",
    operation_id="put_service_trips",
    responses=problems(TimetableChanged, TimetableInvalid, CampusUnknown, *OPERATOR_REFUSALS),
    max_body_size=TIMETABLE_BYTES_MAX,
)
async def put_service_trips(
    body: TimetableBody, revision: Revision, command: ServiceCommand
) -> TimetableView:
    """Put a new version in force. 412 if another operator was first: both versions are kept."""

    def work(uow: UnitOfWork) -> TimetableView:
        saved, _ = timetables.save_timetable(uow, _trips(body), revision, body.note, command.by)
        return _view(uow, saved)

    return await command.transact(TimetableView, work)


@router.post(
    "/previews",
    operation_id="preview_timetable",
    responses=problems(TimetableChanged, TimetableInvalid, CampusUnknown, *OPERATOR_REFUSALS),
    max_body_size=TIMETABLE_BYTES_MAX,
)
async def preview_timetable(
    body: TimetableBody,
    revision: Revision,
    services: InjectedServices,
    actor: Annotated[Actor, Depends(changing(RUN_SERVICE))],
) -> TimetableEffectView:
    """What this version would change. Nothing is saved."""
    _, effect = await roll_back(
        services.transactions,
        lambda uow: timetables.save_timetable(uow, _trips(body), revision, body.note, actor.name),
    )
    return _effect_view(effect)


def _trips(body: TimetableBody) -> tuple[TimetableTrip, ...]:
    return tuple(
        TimetableTrip(
            trip.trip_id,
            tuple((call.stop_id, _seconds(call.leaves)) for call in trip.calls),
            trip.service_id,
        )
        for trip in body.trips
    )


def _view(uow: UnitOfWork, timetable: Timetable) -> TimetableView:
    return TimetableView(
        revision=timetable.revision,
        trips=[
            Trip(
                trip_id=trip.trip_id,
                service_id=trip.service_id,
                calls=[TripCall(stop_id=stop_id, leaves=_clock(second)) for stop_id, second in trip.calls],
            )
            for trip in timetable.trips
        ],
        made_by=timetable.made_by,
        made_at=timetable.made_at,
        note=timetable.note,
        versions=[_version(one) for one in uow.service.timetable_versions(VERSIONS_SHOWN)],
        unserved=[
            UnservedTripView(trip_id=one.trip_id, missing_stops=list(one.missing_stops))
            for one in unserved_trips(timetable.trips, uow.network().stops)
        ],
        tight_legs=[_tight(one) for one in timetables.tight_legs_of(uow, timetable.trips)],
    )


def _version(version: TimetableVersion) -> VersionView:
    return VersionView(
        revision=version.revision,
        trips=version.trips,
        made_by=version.made_by,
        made_at=version.made_at,
        note=version.note,
    )


def _effect_view(effect: TimetableEffect) -> TimetableEffectView:
    return TimetableEffectView(
        added=list(effect.changes.added),
        removed=list(effect.changes.removed),
        changed=list(effect.changes.changed),
        withdrawn=[_affected(one) for one in effect.withdrawn],
        kept=[_affected(one) for one in effect.kept],
        tight_legs=[_tight(one) for one in effect.tight],
    )


def _tight(leg: TightLeg) -> TightLegView:
    return TightLegView(
        trip_id=leg.trip_id,
        from_stop=leg.from_stop,
        to_stop=leg.to_stop,
        leaves=_clock(leg.leaves_s),
        given_s=leg.given_s,
        needed_s=math.ceil(leg.needed_s) if math.isfinite(leg.needed_s) else None,
    )


def _affected(departure: Departure) -> AffectedDeparture:
    return AffectedDeparture(
        departure_id=departure.departure_id,
        leave_at=departure.calls[0].leave_at,
        vehicle_id=departure.vehicle_id,
    )


def _seconds(clock_time: str) -> int:
    hours, minutes, *seconds = (int(part) for part in clock_time.split(":"))
    return hours * 3600 + minutes * 60 + sum(seconds)


def _clock(second: int) -> str:
    """ "08:00", with seconds where there are any."""
    text = f"{second // 3600:02d}:{second % 3600 // 60:02d}"
    return text if second % 60 == 0 else f"{text}:{second % 60:02d}"
