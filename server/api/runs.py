"""Recorded runs: listed and replayed by operators."""

from typing import Annotated

import msgspec
from fastapi import APIRouter, Query, Response

from server.api.access import ReadingOperator
from server.api.formats import NAME_PATTERN, BootId, VehicleId
from server.api.problems import problems
from server.api.run_schemas import RunView, run_view
from server.api.services import Given, Services
from server.domain.errors import RunUnknown, SessionExpired, VehicleUnknown
from server.domain.rides import Ride
from server.domain.runs import Run
from server.domain.vehicles import Vehicle
from server.live.recorded import recorded_scenes
from server.live.scene import Scene
from server.usecases import vehicles
from server.usecases.ports import UnitOfWork

router = APIRouter(prefix="/runs", tags=["runs"])

FRAMES_MAX = 3000


@router.get("", operation_id="list_runs", responses=problems(SessionExpired))
async def list_runs(
    services: Given,
    _: ReadingOperator,
    vehicle_id: Annotated[str | None, Query(pattern=NAME_PATTERN)] = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 100,
) -> list[RunView]:
    """Newest first."""
    found = await services.transactions.read(lambda uow: uow.views.runs(vehicle_id=vehicle_id, limit=limit))
    return [run_view(run) for run in found]


@router.get(
    "/{vehicle_id}/{boot_id}",
    operation_id="get_run",
    responses=problems(RunUnknown, SessionExpired),
)
async def get_run(vehicle_id: VehicleId, boot_id: BootId, services: Given, _: ReadingOperator) -> RunView:
    return run_view(await _find_run(services, vehicle_id, boot_id))


@router.get(
    "/{vehicle_id}/{boot_id}/scenes",
    operation_id="get_run_scenes",
    response_class=Response,
    responses=problems(RunUnknown, VehicleUnknown, SessionExpired)
    | {
        200: {
            "description": "Scenes in order of time, at most 3000; ask on from the last at_ms.",
            "content": {
                "application/json": {
                    "schema": {"type": "array", "items": {"$ref": "#/components/schemas/Scene"}}
                }
            },
        }
    },
)
async def get_run_scenes(
    vehicle_id: VehicleId,
    boot_id: BootId,
    services: Given,
    _: ReadingOperator,
    from_ms: Annotated[int, Query(ge=0, le=1 << 52, description="Unix time")] = 0,
    to_ms: Annotated[int, Query(ge=0, le=1 << 52, description="Unix time")] = 1 << 52,
    step_ms: Annotated[int, Query(ge=20, le=60_000)] = 200,
    limit: Annotated[int, Query(ge=1, le=FRAMES_MAX)] = FRAMES_MAX,
) -> Response:
    """What the live view showed of this run, in the same shape."""
    run = await _find_run(services, vehicle_id, boot_id)
    vehicle, rides = await services.transactions.read(lambda uow: _context(uow, vehicle_id))
    paths = tuple(
        services.segments.path(segment.sha256)
        for segment in run.segments
        if services.segments.has(segment.sha256)
    )

    def work() -> tuple[Scene, ...]:
        return recorded_scenes(run, vehicle, rides, paths, from_ms, to_ms, step_ms, limit)

    scenes = await services.offload.run(work)
    return Response(msgspec.json.encode(scenes), media_type="application/json")


async def _find_run(services: Services, vehicle_id: str, boot_id: str) -> Run:
    run = await services.transactions.read(lambda uow: uow.views.run(vehicle_id, boot_id))
    if run is None:
        raise RunUnknown(f"no run of {vehicle_id} with boot {boot_id} is stored; see GET /runs")
    return run


def _context(uow: UnitOfWork, vehicle_id: str) -> tuple[Vehicle, dict[str, Ride]]:
    rides = {ride.ride_id: ride for ride in uow.views.rides(vehicle_id=vehicle_id, limit=500)}
    return vehicles.vehicle_of(uow, vehicle_id), rides
