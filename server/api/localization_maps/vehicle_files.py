"""A localization map as vehicles download it: authenticated like their link, tile by tile."""

from fastapi import APIRouter, Request, Response

from contract.wire.localization_maps import signed_localization_request
from server.api.formats import Sha256
from server.api.localization_maps.routes import MANIFEST, LocalizationMapId, manifest_response
from server.api.localization_maps.tiles import TILE, tile_response
from server.api.problems import SignatureWrong, TileStoreUnavailable, problems
from server.api.security.vehicle_signature import Signature, SigningVehicle, check_signature
from server.api.services import InjectedServices
from server.domain.errors import (
    KeyUnknown,
    LocalizationMapUnknown,
    LocalizationTileUnknown,
    VehicleUnknown,
)

router = APIRouter(prefix="/localization-maps", tags=["localization maps"])


@router.get(
    "/{map_version}/vehicle-manifest",
    operation_id="get_localization_manifest_for_vehicle",
    response_class=Response,
    responses=problems(LocalizationMapUnknown, SignatureWrong, KeyUnknown, VehicleUnknown) | MANIFEST,
)
async def get_localization_manifest_for_vehicle(
    map_version: LocalizationMapId,
    request: Request,
    services: InjectedServices,
    vehicle_id: SigningVehicle,
    signature: Signature,
) -> Response:
    """Its SHA-256 is the one that the vehicle's link has announced."""
    await check_signature(
        services, vehicle_id, signature, signed_localization_request(vehicle_id, map_version)
    )
    return await manifest_response(services, request, map_version)


@router.get(
    "/{map_version}/vehicle-tiles/{sha256}",
    operation_id="get_localization_tile_for_vehicle",
    response_class=Response,
    responses=problems(
        LocalizationMapUnknown,
        LocalizationTileUnknown,
        TileStoreUnavailable,
        SignatureWrong,
        KeyUnknown,
        VehicleUnknown,
    )
    | TILE,
)
async def get_localization_tile_for_vehicle(
    map_version: LocalizationMapId,
    sha256: Sha256,
    request: Request,
    services: InjectedServices,
    vehicle_id: SigningVehicle,
    signature: Signature,
) -> Response:
    """One signature serves all tiles of a version."""
    await check_signature(
        services, vehicle_id, signature, signed_localization_request(vehicle_id, map_version)
    )
    return await tile_response(services, request, map_version, sha256)
