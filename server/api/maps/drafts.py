"""Drafts of the map: made, drawn on by revision, checked, driven on trial, published."""

import itertools
import math
from typing import Annotated

import msgspec
from fastapi import APIRouter, Header, Path, Query, Response

from contract.roads.load import encode_map
from contract.roads.model import Lane, RoadMap, Section
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_line
from server.api.commands import Command, DrawCommand, PublishCommand
from server.api.formats import NAME_PATTERN
from server.api.maps.elements import Id, changed_map, differences, drawn
from server.api.maps.routes import FILE, file_response, stored_view
from server.api.maps.schemas import (
    ChangeBody,
    DraftBody,
    DraftMap,
    DraftProblems,
    DraftView,
    FixBody,
    MapDiff,
    MapVersionView,
    TrialDrive,
    draft_view,
    problems_view,
)
from server.api.paging import ListLimit, Page, microseconds_of, paged
from server.api.problems import problems
from server.api.security.access import (
    OPERATOR_REFUSALS,
    READER_REFUSALS,
    SECOND_FACTOR_REFUSALS,
    Reader,
)
from server.api.services import InjectedServices, Services
from server.domain.errors import (
    CampusUnknown,
    DraftChanged,
    DraftUnknown,
    DraftUnsound,
    MapInUse,
    MapInvalid,
    MapUnknown,
    NoSuchFix,
    StopUnknown,
    StopUnreachable,
    TooManyDrafts,
)
from server.domain.roads.maps import MapDraft
from server.usecases.fleet import map_drafts
from server.usecases.ports.maps import ExportFormat
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/maps/drafts", tags=["maps"])

# Of one change: all lanes of a campus, redrawn.
CHANGE_BYTES_MAX = 8 << 20
DraftId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["draft-1"])]
Revision = Annotated[
    int,
    Header(alias="If-Match", ge=1, description="The revision that you have seen.", examples=[4]),
]
StopId = Annotated[Id, Query(examples=["library"])]


@router.get("", operation_id="list_map_drafts", responses=paged(*READER_REFUSALS))
async def list_map_drafts(
    services: InjectedServices, _: Reader, page: Page, limit: ListLimit = None
) -> list[DraftView]:
    """All drafts, the one that was changed last first."""
    found = await services.transactions.read(lambda uow: uow.map_drafts.all())
    return [draft_view(draft) for draft in page.cut(found, limit, _newest_first)]


def _newest_first(draft: MapDraft) -> tuple[int, str]:
    return -microseconds_of(draft.changed_at), draft.draft_id


@router.post(
    "",
    operation_id="make_map_draft",
    status_code=201,
    responses=problems(MapUnknown, DraftUnknown, CampusUnknown, TooManyDrafts, *OPERATOR_REFUSALS),
)
async def make_map_draft(body: DraftBody, command: DrawCommand) -> DraftView:
    """A copy of a stored version, or of another draft, to draw on."""

    def work(uow: UnitOfWork) -> DraftView:
        if body.draft_id is not None:
            of = map_drafts.draft_of(uow, body.draft_id)
            return draft_view(
                map_drafts.add_draft(uow, body.name or of.name, of.content, of.based_on, command.by)
            )
        version = body.map_version or uow.network().map_version
        road_map = map_drafts.stored_map(uow, version)
        content = draft_content(road_map)
        return draft_view(map_drafts.add_draft(uow, body.name or road_map.name, content, version, command.by))

    return await command.transact(DraftView, work)


@router.get(
    "/{draft_id}",
    operation_id="get_map_draft",
    response_model=DraftMap,
    responses=problems(DraftUnknown, *READER_REFUSALS),
)
async def get_map_draft(draft_id: DraftId, services: InjectedServices, _: Reader) -> Response:
    """Everything that is drawn."""
    draft, road_map = await _read(services, draft_id)
    document = {
        "draft": draft_view(draft).model_dump(mode="json"),
        "elements": drawn(road_map),
        "buildings": [building.outline for building in road_map.buildings],
    }
    # Some megabytes: not sent through the models one by one.
    return Response(msgspec.json.encode(document), media_type="application/json")


@router.patch(
    "/{draft_id}",
    operation_id="change_map_draft",
    max_body_size=CHANGE_BYTES_MAX,
    responses=problems(DraftUnknown, DraftChanged, *OPERATOR_REFUSALS),
)
async def change_map_draft(
    draft_id: DraftId, body: ChangeBody, revision: Revision, services: InjectedServices, command: DrawCommand
) -> DraftView:
    """Refused with 412, and nothing overwritten, where someone else has changed the draft since."""
    _draft, road_map = await _read(services, draft_id)
    changed = await services.offload.run(lambda: draft_content(changed_map(road_map, body.put, body.removed)))
    return await _saved(command, draft_id, revision, changed)


@router.post(
    "/{draft_id}/fixes",
    operation_id="mend_map_draft",
    responses=problems(DraftUnknown, DraftChanged, NoSuchFix, *OPERATOR_REFUSALS),
)
async def mend_map_draft(
    draft_id: DraftId, body: FixBody, revision: Revision, services: InjectedServices, command: DrawCommand
) -> DraftView:
    """Mend one problem. Load the draft again to see how."""
    _draft, road_map = await _read(services, draft_id)

    def mend() -> bytes:
        return draft_content(services.maps.mended(services.maps.completed(road_map), body.defect, body.where))

    return await _saved(command, draft_id, revision, await services.offload.run(mend))


@router.get(
    "/{draft_id}/problems",
    operation_id="check_map_draft",
    responses=problems(DraftUnknown, *READER_REFUSALS),
)
async def check_map_draft(draft_id: DraftId, services: InjectedServices, _: Reader) -> DraftProblems:
    """What keeps the draft from being published, each with its place."""
    draft, road_map = await _read(services, draft_id)
    return await services.offload.run(
        lambda: problems_view(draft.revision, services.maps.completed(road_map), services.maps)
    )


@router.get(
    "/{draft_id}/diff",
    operation_id="compare_map_draft",
    responses=problems(DraftUnknown, CampusUnknown, *READER_REFUSALS),
)
async def compare_map_draft(draft_id: DraftId, services: InjectedServices, _: Reader) -> MapDiff:
    """What the draft has added, removed and changed against the map in force."""

    def work(uow: UnitOfWork) -> tuple[str, RoadMap, MapDraft]:
        version = uow.network().map_version
        return version, map_drafts.stored_map(uow, version), map_drafts.draft_of(uow, draft_id)

    version, old, draft = await services.transactions.read(work)
    kinds = await services.offload.run(lambda: differences(old, map_drafts.road_map_of(draft)))
    return MapDiff.model_validate({"against": version, "kinds": kinds})


@router.get(
    "/{draft_id}/trial-drives",
    operation_id="try_map_draft",
    responses=problems(DraftUnknown, StopUnknown, StopUnreachable, *READER_REFUSALS),
)
async def try_map_draft(
    draft_id: DraftId, from_stop: StopId, to_stop: StopId, services: InjectedServices, _: Reader
) -> TrialDrive:
    """The fastest way between two stops of the draft, and how long a shuttle takes for it."""
    _draft, road_map = await _read(services, draft_id)
    cap_mps = (await services.transactions.read(lambda uow: uow.rules)).speed_cap_mps
    return await services.offload.run(lambda: _driven(road_map, from_stop, to_stop, cap_mps))


@router.get(
    "/{draft_id}/exports/{kind}",
    operation_id="export_map_draft",
    response_class=Response,
    responses=problems(DraftUnknown, *READER_REFUSALS) | FILE,
)
async def export_map_draft(
    draft_id: DraftId, kind: ExportFormat, services: InjectedServices, _: Reader
) -> Response:
    _draft, road_map = await _read(services, draft_id)
    content = await services.offload.run(
        lambda: services.maps.exported(services.maps.completed(road_map), kind)
    )
    return file_response(content, kind, draft_id)


@router.post(
    "/{draft_id}/publications",
    operation_id="publish_map_draft",
    status_code=201,
    responses=problems(
        DraftUnknown,
        DraftChanged,
        DraftUnsound,
        MapInvalid,
        MapInUse,
        *OPERATOR_REFUSALS,
        *SECOND_FACTOR_REFUSALS,
    ),
)
async def publish_map_draft(
    draft_id: DraftId, revision: Revision, services: InjectedServices, command: PublishCommand
) -> MapVersionView:
    """Put the draft in force. It must have no problems, and no shuttle may be under way on what it changes.
    Every vehicle downloads it by itself. The draft is gone; the former map stays stored."""
    _draft, road_map = await _read(services, draft_id)

    def complete() -> bytes:
        completed = services.maps.completed(road_map)
        view = problems_view(revision, completed, services.maps)
        map_drafts.require_sound(view.count, view.problems[0].where if view.problems else "")
        return encode_map(completed)

    content = await services.offload.run(complete)

    def work(uow: UnitOfWork) -> MapVersionView:
        return stored_view(map_drafts.publish_draft(uow, draft_id, revision, content, command.by))

    return await command.transact(MapVersionView, work)


@router.delete(
    "/{draft_id}",
    operation_id="discard_map_draft",
    status_code=204,
    responses=problems(DraftUnknown, *OPERATOR_REFUSALS),
)
async def discard_map_draft(draft_id: DraftId, command: DrawCommand) -> None:
    def work(uow: UnitOfWork) -> None:
        map_drafts.discard_draft(uow, draft_id, command.by)

    await command.transact(type(None), work)


def draft_content(road_map: RoadMap) -> bytes:
    """Without sections: they are derived when the draft is checked."""
    return encode_map(msgspec.structs.replace(road_map, sections=(), map_version=""))


async def _read(services: Services, draft_id: str) -> tuple[MapDraft, RoadMap]:
    """Raises DraftUnknown."""
    draft = await services.transactions.read(lambda uow: map_drafts.draft_of(uow, draft_id))
    return draft, await services.offload.run(lambda: map_drafts.road_map_of(draft))


async def _saved(command: Command, draft_id: str, revision: int, content: bytes) -> DraftView:
    def work(uow: UnitOfWork) -> DraftView:
        return draft_view(map_drafts.change_draft(uow, draft_id, revision, content, command.by))

    return await command.transact(DraftView, work)


def _driven(road_map: RoadMap, from_stop: str, to_stop: str, cap_mps: float) -> TrialDrive:
    """Raises StopUnknown, StopUnreachable."""
    stops = {stop.stop_id: stop for stop in road_map.stops}
    lanes = {lane.lane_id for lane in road_map.lanes if len(lane.points) > 1}
    for stop_id in (from_stop, to_stop):
        if stop_id not in stops or stops[stop_id].lane_id not in lanes:
            raise StopUnknown(f"no stop {stop_id} lies on a lane of the draft")
    known = tuple(
        msgspec.structs.replace(lane, successors=tuple(name for name in lane.successors if name in lanes))
        for lane in road_map.lanes
        if lane.lane_id in lanes
    )
    # A way needs no tiles: one section a lane will do, and saves seconds while somebody draws.
    whole = tuple(Section(f"{one.lane_id}/0", one.lane_id, 0.0, _length_m(one)) for one in known)
    network = RoadNetwork(msgspec.structs.replace(road_map, lanes=known, sections=whole))
    start, end = stops[from_stop], stops[to_stop]
    route = find_route(network, start.lane_id, start.s_m, end.lane_id, end.s_m, speed_cap_mps=cap_mps)
    if route is None or not math.isfinite(route.time_s):
        raise StopUnreachable(f"no way leads from {start.name} to {end.name}; join the lanes between them")
    line = route_line(network, route).points
    xy = [round(float(value), 2) for value in line.ravel()]
    return TrialDrive(length_m=round(route.length_m, 1), time_s=round(route.time_s, 1), xy=xy)


def _length_m(lane: Lane) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise(lane.points))
