"""The past of the whole fleet: what happened in a stretch of time, and where every vehicle was."""

from collections.abc import Sequence
from datetime import datetime
from typing import Annotated, Any, TypeVar

import msgspec
from fastapi import APIRouter, Query, Response

from server.api.problems import problems
from server.api.security.access import READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.domain.instants import moment_of_ns, ms_of
from server.live import past
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/replays", tags=["runs"])

T = TypeVar("T")

# A day whose clocks are set back, and a bit.
DAY_S_MAX = 26 * 3600
POSITIONS_S_MAX = 3600
# Of one answer: an hour of 8 vehicles, 5 minutes of 100.
ROWS_MAX = 60_000
MARKS_MAX = 20_000
# A day of 50 busy shuttles has 51,000.
STOPS_MAX = 60_000
RIDES_MAX = 20_000
RUNS_MAX = 2_000
_MS_MAX = 1 << 43  # year 2248: in nanoseconds it still fits into 64 bits

From = Annotated[int, Query(ge=0, le=_MS_MAX, description="Unix time, milliseconds")]


def answer_of(name: str, description: str) -> dict[int | str, dict[str, Any]]:
    """The successful answer of an endpoint, in one of the schemas of `server.api.openapi`."""
    schema = {"$ref": f"#/components/schemas/{name}"}
    return {200: {"description": description, "content": {"application/json": {"schema": schema}}}}


@router.get(
    "/fleet",
    operation_id="get_fleet_past",
    response_class=Response,
    responses=problems(*READER_REFUSALS)
    | answer_of("FleetPast", "Vehicles, marks, rides and recordings of that time."),
)
async def get_fleet_past(
    services: InjectedServices,
    _: Reader,
    from_ms: From,
    seconds: Annotated[int, Query(ge=1, le=DAY_S_MAX)] = 24 * 3600,
) -> Response:
    """What the fleet did from a time on. The positions come from `/replays/positions`."""
    since, until = moment_at(from_ms), moment_at(from_ms + 1000 * seconds)
    found = await services.transactions.read(lambda uow: _past(uow, since, until))
    body = await services.offload.run(lambda: msgspec.json.encode(found))
    return Response(body, media_type="application/json")


@router.get(
    "/positions",
    operation_id="get_fleet_positions",
    response_class=Response,
    responses=problems(*READER_REFUSALS)
    | answer_of("FleetPositions", "Positions in order of time; ask on from `to_ms`."),
)
async def get_fleet_positions(
    services: InjectedServices,
    _: Reader,
    from_ms: From,
    seconds: Annotated[int, Query(ge=1, le=POSITIONS_S_MAX)] = 120,
    step_ms: Annotated[int, Query(ge=100, le=60_000)] = 1000,
) -> Response:
    """Where every vehicle was, as far as 60,000 stored positions reach; `to_ms` says how far."""
    to_ms = from_ms + 1000 * seconds
    found = await services.transactions.read(
        lambda uow: uow.past.positions(moment_at(from_ms), moment_at(to_ms), ROWS_MAX + 1)
    )

    def work() -> bytes:
        cuts = Cuts()
        shown = cuts.of(found, ROWS_MAX)
        return msgspec.json.encode(past.fleet_positions(shown, from_ms, to_ms, step_ms, cuts.is_cut))

    return Response(await services.offload.run(work), media_type="application/json")


def _past(uow: UnitOfWork, since: datetime, until: datetime) -> past.FleetPast:
    stored = uow.past
    cuts = Cuts()
    events = cuts.of(stored.vehicle_events(since, until, past.EVENT_KINDS, MARKS_MAX + 1), MARKS_MAX)
    # There are many of these: they must not crowd out a takeover.
    stops = cuts.of(stored.vehicle_events(since, until, past.STOP_KINDS, STOPS_MAX + 1), STOPS_MAX)
    incidents = cuts.of(stored.incidents(since, until, MARKS_MAX + 1), MARKS_MAX)
    said = cuts.of(stored.server_events(since, until, past.INTERVENTIONS, MARKS_MAX + 1), MARKS_MAX)
    rides = cuts.of(stored.rides(since, until, RIDES_MAX + 1), RIDES_MAX)
    runs = cuts.of(stored.runs(since, until, RUNS_MAX + 1), RUNS_MAX)
    return past.FleetPast(
        from_ms=ms_of(since),
        to_ms=ms_of(until),
        vehicles=[past.past_vehicle(vehicle) for vehicle in uow.vehicles.all()],
        marks=past.marks((*events, *stops), incidents, said),
        rides=[past.past_ride(ride) for ride in rides],
        runs=[past.past_run(run) for run in runs],
        is_cut=cuts.is_cut,
    )


class Cuts:
    """Lists that were asked for one more than is told: one that is exactly full is whole."""

    def __init__(self) -> None:
        self.is_cut = False

    def of(self, found: Sequence[T], most: int) -> Sequence[T]:
        self.is_cut |= len(found) > most
        return found[:most]


def moment_at(at_ms: int) -> datetime:
    return moment_of_ns(at_ms * 1_000_000)
