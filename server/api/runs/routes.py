"""Recorded runs: listed and replayed by operators."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec
from fastapi import APIRouter, Query, Response

from contract.roads.load import MapError
from contract.roads.network import RoadNetwork
from contract.runlog.reader import RunLogError
from server.api.campus.schemas import MapGeometry, map_geometry
from server.api.formats import NAME_PATTERN, BootId, VehicleId
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import SegmentStoreUnavailable, problems
from server.api.recordings.schemas import RunMark
from server.api.runs.marks import known_marks, run_marks, run_span
from server.api.runs.schemas import RunView, run_view
from server.api.runs.segments import fetched
from server.api.security.access import READER_REFUSALS, Reader
from server.api.services import InjectedServices, Services
from server.domain.errors import RunMapUnreadable, RunUnknown, VehicleUnknown
from server.domain.fleet.vehicles import Vehicle
from server.domain.orders.orders import IssuedOrder
from server.domain.record.runs import Run
from server.domain.rides.rides import Ride
from server.live.recorded import OrderKey, Report, recorded_network, recorded_reports, recorded_scenes
from server.live.recorded_onboard import recorded_onboard
from server.live.recorded_scans import recorded_scans
from server.usecases.fleet import campus
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

router = APIRouter(prefix="/runs", tags=["runs"])

FRAMES_MAX = 3000
ONBOARD_S_MAX = 30
# Of 2,000 points each.
SCANS_S_MAX = 10


@router.get("", operation_id="list_runs", responses=paged(*READER_REFUSALS))
async def list_runs(
    services: InjectedServices,
    _: Reader,
    page: Page,
    vehicle_id: Annotated[str | None, Query(pattern=NAME_PATTERN)] = None,
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 100,
) -> list[RunView]:
    """Newest first."""
    ended = page.after(int, str, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]), str(ended[2]))
    found = await services.transactions.read(
        lambda uow: uow.views.runs(vehicle_id=vehicle_id, limit=limit + 1, after=after)
    )
    shown = page.first(
        found, limit, lambda run: (microseconds_of(run.started_at), run.boot_id, run.vehicle_id)
    )
    return [run_view(run) for run in shown]


@router.get(
    "/{vehicle_id}/{boot_id}",
    operation_id="get_run",
    responses=problems(RunUnknown, *READER_REFUSALS),
)
async def get_run(vehicle_id: VehicleId, boot_id: BootId, services: InjectedServices, _: Reader) -> RunView:
    return run_view(await _find_run(services, vehicle_id, boot_id))


@router.get(
    "/{vehicle_id}/{boot_id}/scenes",
    operation_id="get_run_scenes",
    response_class=Response,
    responses=problems(RunUnknown, VehicleUnknown, SegmentStoreUnavailable, *READER_REFUSALS)
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
    services: InjectedServices,
    _: Reader,
    from_ms: Annotated[int, Query(ge=0, le=1 << 52, description="Unix time")] = 0,
    to_ms: Annotated[int, Query(ge=0, le=1 << 52, description="Unix time")] = 1 << 52,
    step_ms: Annotated[int, Query(ge=20, le=60_000)] = 200,
    limit: Annotated[int, Query(ge=1, le=FRAMES_MAX)] = FRAMES_MAX,
) -> Response:
    """What the live view showed of this run, in the same shape."""
    run = await _find_run(services, vehicle_id, boot_id)
    paths = await _kept(services, run)
    found = await services.offload.run(lambda: recorded_reports(paths, from_ms, to_ms, step_ms, limit))
    context = await services.transactions.read(lambda uow: _context(uow, run, found))

    def work() -> bytes:
        scenes = recorded_scenes(run, context.vehicle, found, context.rides, context.orders, context.network)
        return msgspec.json.encode(scenes)

    return Response(await services.offload.run(work), media_type="application/json")


@router.get(
    "/{vehicle_id}/{boot_id}/onboard",
    operation_id="get_run_onboard",
    response_class=Response,
    responses=problems(RunUnknown, SegmentStoreUnavailable, *READER_REFUSALS)
    | {
        200: {
            "description": "In order of time, 5 a second. Empty for runs of an older agent.",
            "content": {
                "application/json": {
                    "schema": {"type": "array", "items": {"$ref": "#/components/schemas/OnboardMoment"}}
                }
            },
        }
    },
)
async def get_run_onboard(
    vehicle_id: VehicleId,
    boot_id: BootId,
    services: InjectedServices,
    _: Reader,
    from_ms: Annotated[int, Query(ge=0, le=1 << 43, description="Unix time")],
    seconds: Annotated[int, Query(ge=1, le=ONBOARD_S_MAX)] = 10,
) -> Response:
    """What the vehicle saw and planned: obstacle cells, limits, the s-t graph, the times of its ticks."""
    run = await _find_run(services, vehicle_id, boot_id)
    paths = await _kept(services, run)

    def work() -> bytes:
        return msgspec.json.encode(recorded_onboard(paths, from_ms, from_ms + 1000 * seconds))

    return Response(await services.offload.run(work), media_type="application/json")


@router.get(
    "/{vehicle_id}/{boot_id}/scans",
    operation_id="get_run_scans",
    response_class=Response,
    responses=problems(RunUnknown, SegmentStoreUnavailable, *READER_REFUSALS)
    | {
        200: {
            "description": "In order of time, one a second. Empty for a vehicle that compares no scans.",
            "content": {
                "application/json": {
                    "schema": {"type": "array", "items": {"$ref": "#/components/schemas/ScanMoment"}}
                }
            },
        }
    },
)
async def get_run_scans(
    vehicle_id: VehicleId,
    boot_id: BootId,
    services: InjectedServices,
    _: Reader,
    from_ms: Annotated[int, Query(ge=0, le=1 << 43, description="Unix time")],
    seconds: Annotated[int, Query(ge=1, le=SCANS_S_MAX)] = 2,
) -> Response:
    """Lidar scans as the vehicle compared them with its point map, thinned: which points lie on the map."""
    run = await _find_run(services, vehicle_id, boot_id)
    paths = await _kept(services, run)

    def work() -> bytes:
        return msgspec.json.encode(recorded_scans(paths, from_ms, from_ms + 1000 * seconds))

    return Response(await services.offload.run(work), media_type="application/json")


@router.get(
    "/{vehicle_id}/{boot_id}/marks",
    operation_id="get_run_marks",
    responses=problems(RunUnknown, SegmentStoreUnavailable, *READER_REFUSALS),
)
async def get_run_marks(
    vehicle_id: VehicleId, boot_id: BootId, services: InjectedServices, _: Reader
) -> list[RunMark]:
    """Operators' marks, and where recordings begin and end, in order of time.

    Those of the files, and those that the server knows and no file has yet.
    """
    run = await _find_run(services, vehicle_id, boot_id)
    paths = await _kept(services, run)
    span = await services.offload.run(lambda: run_span(run, paths))
    known: list[RunMark] = []
    if span is not None:
        known = await services.transactions.read(lambda uow: known_marks(uow, vehicle_id, span))
    return await services.offload.run(lambda: run_marks(paths, known))


@router.get(
    "/{vehicle_id}/{boot_id}/map",
    operation_id="get_run_map",
    responses=problems(RunUnknown, RunMapUnreadable, SegmentStoreUnavailable, *READER_REFUSALS),
)
async def get_run_map(
    vehicle_id: VehicleId, boot_id: BootId, services: InjectedServices, _: Reader
) -> MapGeometry:
    """The map of the run, which may differ from the active one."""
    run = await _find_run(services, vehicle_id, boot_id)
    paths = await _kept(services, run)
    if not paths:
        raise RunUnknown(f"nothing of run {boot_id} of {vehicle_id} is kept here")

    def work() -> MapGeometry:
        try:
            network = recorded_network(paths)
        except (RunLogError, MapError) as error:
            raise RunMapUnreadable(f"the recording's road map cannot be read ({error})") from error
        return map_geometry(network, campus.stops_of(network))

    return await services.offload.run(work)


async def _kept(services: Services, run: Run) -> tuple[Path, ...]:
    """The files of the run's segments that are still stored. Raises SegmentStoreUnavailable."""
    found = [await fetched(services, segment.sha256) for segment in run.segments]
    return tuple(path for path in found if path is not None)


async def _find_run(services: Services, vehicle_id: str, boot_id: str) -> Run:
    run = await services.transactions.read(lambda uow: uow.views.run(vehicle_id, boot_id))
    if run is None:
        raise RunUnknown(f"no run of {vehicle_id} with boot {boot_id} is stored; see GET /runs")
    return run


@dataclass(frozen=True, slots=True)
class _Context:
    """What the store has in addition to the recording."""

    vehicle: Vehicle
    rides: dict[str, Ride]
    orders: dict[OrderKey, IssuedOrder]
    network: RoadNetwork | None


def _context(uow: UnitOfWork, run: Run, found: tuple[Report, ...]) -> _Context:
    vehicle_id = run.vehicle_id
    followed = {
        key: uow.orders.find(vehicle_id, *key) for key in sorted({report.order_key for report in found})
    }
    return _Context(
        vehicle=enrolled_vehicle(uow, vehicle_id),
        rides={ride.ride_id: ride for ride in uow.views.rides(vehicle_id=vehicle_id, limit=500)},
        orders={key: order for key, order in followed.items() if order is not None},
        network=uow.network_at(run.map_version),
    )
