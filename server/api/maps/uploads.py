"""A file becomes a draft: written to disk as it comes, at most 64 MiB, read beside the event loop."""

import tempfile
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request

from server.api.commands import Command
from server.api.maps.drafts import draft_content
from server.api.maps.schemas import DraftView, draft_view
from server.api.problems import problems
from server.api.security.access import OPERATOR_REFUSALS, Actor, changing, now_ns
from server.api.security.permissions import DRAW_MAPS
from server.api.security.request_origin import address_of, operation_of
from server.api.services import InjectedServices
from server.domain.errors import MapElsewhere, MapInvalid, TooManyDrafts
from server.domain.record.audit import AuditAction, Caller
from server.usecases.fleet import map_drafts
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/maps/drafts", tags=["maps"])

# A campus has some megabytes in any format. What is larger is a city, and would take the server's memory.
FILE_BYTES_MAX = 64 << 20
FileName = Annotated[
    str,
    Query(
        max_length=200,
        pattern=r"^[^\x00-\x1f/\\]+$",
        description="Its ending tells OpenStreetMap's XML and PBF apart.",
        examples=["campus.osm.pbf"],
    ),
]


@router.post(
    "/files",
    operation_id="import_map_draft",
    status_code=201,
    max_body_size=FILE_BYTES_MAX,
    responses=problems(MapInvalid, MapElsewhere, TooManyDrafts, *OPERATOR_REFUSALS),
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def import_map_draft(
    file_name: FileName,
    request: Request,
    services: InjectedServices,
    actor: Annotated[Actor, Depends(changing(DRAW_MAPS))],
    elsewhere: Annotated[bool, Query(description="The file is meant, although it lies far away.")] = False,
) -> DraftView:
    """OpenStreetMap (XML, PBF), GeoJSON, Lanelet2 or our own format, told by content. The answer lists every
    repair and all that was left out."""
    services.limits.commands.take(actor.account, now_ns(services))
    action = AuditAction(operation_of(request), "", file_name)
    caller = Caller(actor.kind, actor.name, address_of(request))
    command = Command(services.transactions, actor.kind, actor.name, actor.account, None, b"", caller, action)
    in_force = await services.transactions.read(map_drafts.map_in_force)
    with tempfile.TemporaryDirectory(prefix="campusloop-map-") as folder:
        path = Path(folder) / f"file{''.join(Path(file_name).suffixes[-2:]).lower()}"
        with path.open("wb") as file:
            async for chunk in request.stream():
                file.write(chunk)
        road_map, repairs = await services.offload.run(
            lambda: services.maps.imported(path, in_force, services.campus_id)
        )

    def work(uow: UnitOfWork) -> DraftView:
        if not elsewhere:
            map_drafts.require_near(in_force, road_map.origin)
        draft = map_drafts.add_draft(uow, file_name, draft_content(road_map), "", command.by)
        return draft_view(draft, repairs)

    return await command.transact(DraftView, work)
