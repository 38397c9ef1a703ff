"""Figures of demand and service over weeks, and of driving over a day."""

from typing import Annotated

import msgspec
from fastapi import APIRouter, Query, Response

from contract.wire.messages import FaultRaised, ModeChanged
from server.api.problems import problems
from server.api.replays.routes import DAY_S_MAX, From, answer_of, moment_at
from server.api.security.access import READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.domain.record.statistics import DrivingFigures, SpeedBin, service_figures
from server.fleet.hub import FLUSH_EVERY_S
from server.live import past
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/statistics", tags=["runs"])

# Five weeks.
SERVICE_S_MAX = 35 * 86_400
RIDES_MAX = 50_000
EVENTS_MAX = 50_000


@router.get(
    "/service",
    operation_id="get_service_figures",
    response_class=Response,
    responses=problems(*READER_REFUSALS)
    | answer_of("ServiceFigures", "Demand by the hour, and how rides went."),
)
async def get_service_figures(
    services: InjectedServices,
    _: Reader,
    from_ms: From,
    seconds: Annotated[int, Query(ge=1, le=SERVICE_S_MAX)] = 7 * 86_400,
) -> Response:
    """Of rides that were wanted for this time, at most 50,000."""
    since, until = moment_at(from_ms), moment_at(from_ms + 1000 * seconds)

    def read(uow: UnitOfWork) -> bytes:
        # One more than is counted: it alone says that there are more.
        found = uow.past.wanted_rides(since, until, RIDES_MAX + 1)
        rides = found[:RIDES_MAX]
        timezone = uow.network().road_map.timezone
        is_cut = len(found) > RIDES_MAX
        return msgspec.json.encode(
            service_figures(rides, from_ms, from_ms + 1000 * seconds, timezone, is_cut)
        )

    return Response(await services.transactions.read(read), media_type="application/json")


@router.get(
    "/driving",
    operation_id="get_driving_figures",
    response_class=Response,
    responses=problems(*READER_REFUSALS)
    | answer_of("DrivingFigures", "Speeds, distance, brakings, takeovers."),
)
async def get_driving_figures(
    services: InjectedServices,
    _: Reader,
    from_ms: From,
    seconds: Annotated[int, Query(ge=1, le=DAY_S_MAX)] = 86_400,
) -> Response:
    """Of every stored position of the fleet, so of a day at most; of its events at most 50,000."""
    since, until = moment_at(from_ms), moment_at(from_ms + 1000 * seconds)

    def read(uow: UnitOfWork) -> bytes:
        speeds = uow.past.speeds(since, until)
        kinds = ("mode_changed", "fault_raised")
        found = uow.past.vehicle_events(since, until, kinds, EVENTS_MAX + 1)
        events = [one.body for one in found[:EVENTS_MAX]]
        modes = [body.mode for body in events if isinstance(body, ModeChanged)]
        faults = [body for body in events if isinstance(body, FaultRaised) and not body.cleared]
        figures = DrivingFigures(
            from_ms=from_ms,
            to_ms=from_ms + 1000 * seconds,
            speeds=[SpeedBin(one.from_kmh, one.positions) for one in speeds],
            distance_m=FLUSH_EVERY_S * sum(one.speeds_mps for one in speeds),
            brakings=sum(body.fault.code.startswith(past.BRAKING) for body in faults),
            takeovers=modes.count("manual"),
            minimal_risk_stops=modes.count("minimal_risk"),
            is_cut=len(found) > EVENTS_MAX,
        )
        return msgspec.json.encode(figures)

    return Response(await services.transactions.read(read), media_type="application/json")
