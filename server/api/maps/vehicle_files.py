"""A map as vehicles download it: authenticated like their link, compressed, with the announced hash."""

from functools import lru_cache

from fastapi import APIRouter, Request, Response

from contract.wire.maps import signed_map_request
from server.api.content_coding import CodedBody, coded_body
from server.api.maps.routes import FILE, MapVersionId
from server.api.problems import SignatureWrong, problems
from server.api.security.vehicle_signature import Signature, SigningVehicle, check_signature
from server.api.services import InjectedServices
from server.domain.errors import KeyUnknown, MapUnknown, VehicleUnknown
from server.usecases.fleet import map_drafts

router = APIRouter(prefix="/maps", tags=["maps"])


@router.get(
    "/{map_version}/vehicle-file",
    operation_id="get_map_for_vehicle",
    response_class=Response,
    responses=problems(MapUnknown, SignatureWrong, KeyUnknown, VehicleUnknown) | FILE,
)
async def get_map_for_vehicle(
    map_version: MapVersionId,
    request: Request,
    services: InjectedServices,
    vehicle_id: SigningVehicle,
    signature: Signature,
) -> Response:
    """The map as it is stored: its SHA-256 is the one that the vehicle's link has announced."""
    signed = signed_map_request(vehicle_id, map_version)
    await check_signature(services, vehicle_id, signature, signed)
    content = await services.transactions.read(lambda uow: map_drafts.stored_content(uow, map_version))
    body = await services.offload.run(lambda: _compressed(content))
    accepted = request.headers.get("Accept-Encoding", "")
    return body.response(accepted, "application/json", f'"{map_version}"', {"Cache-Control": "no-store"})


@lru_cache(maxsize=2)
def _compressed(content: bytes) -> CodedBody:
    """A whole fleet downloads a map at about the same time."""
    return coded_body(content)
