"""Parcels of scans: sent by vehicles by content hash."""

from pathlib import Path

from fastapi import APIRouter, Request, Response

from contract.scan_parcels.parcels import ParcelError, ParcelHeader, checked_parcel
from contract.wire.scans import signed_parcel
from server.api.formats import Sha256
from server.api.problems import (
    ParcelHashWrong,
    ParcelTooLarge,
    ParcelUnreadable,
    ScanStoreUnavailable,
    SignatureWrong,
    problems,
)
from server.api.scans.schemas import ParcelView
from server.api.security.vehicle_signature import Signature, SigningVehicle, check_signature
from server.api.services import InjectedServices, Services
from server.domain.errors import CampusUnknown, KeyUnknown, ParcelRefused, VehicleUnknown
from server.domain.fleet.scans import ScanParcel
from server.store.segments.incoming import SegmentHashError, SegmentSizeError
from server.store.segments.segment_store import SegmentStoreError
from server.usecases.fleet import scans

router = APIRouter(prefix="/scan-parcels", tags=["scans"])

# Vehicles end a parcel at 8 MB.
PARCEL_BYTES_MAX = 64 * 1024 * 1024


@router.put(
    "/{sha256}",
    operation_id="put_scan_parcel",
    status_code=201,
    max_body_size=PARCEL_BYTES_MAX,
    responses=problems(
        ParcelHashWrong,
        ParcelUnreadable,
        ParcelTooLarge,
        ParcelRefused,
        ScanStoreUnavailable,
        SignatureWrong,
        KeyUnknown,
        VehicleUnknown,
        CampusUnknown,
    )
    | {200: {"model": ParcelView, "description": "The parcel was there already."}},
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def put_scan_parcel(
    sha256: Sha256,
    request: Request,
    response: Response,
    services: InjectedServices,
    vehicle_id: SigningVehicle,
    signature: Signature,
) -> ParcelView:
    """A parcel, by the SHA-256 of its bytes. A repeat is harmless."""
    await check_signature(services, vehicle_id, signature, signed_parcel(vehicle_id, sha256))
    known = await _kept(services, vehicle_id, sha256)
    if known is not None:
        response.status_code = 200
        return ParcelView(
            sha256=sha256, request_id=known.request_id, scans=known.scans, size_bytes=known.size_bytes
        )
    header, size_bytes = await _receive(services, request, vehicle_id, sha256)
    if not await services.transactions.run(lambda uow: scans.add_parcel(uow, header, sha256, size_bytes)):
        response.status_code = 200
    return ParcelView(sha256=sha256, request_id=header.request_id, scans=header.scans, size_bytes=size_bytes)


async def _receive(
    services: Services, request: Request, vehicle_id: str, sha256: str
) -> tuple[ParcelHeader, int]:
    """The header of a parcel, of which all bytes are kept now."""
    try:
        return await _received(services, request, vehicle_id, sha256)
    except OSError as error:
        raise ScanStoreUnavailable(f"the upload cannot be kept now ({error}); send it again") from error


async def _received(
    services: Services, request: Request, vehicle_id: str, sha256: str
) -> tuple[ParcelHeader, int]:
    """Raises OSError."""
    store, offload = services.scans, services.offload
    with store.receive(sha256, services.ids.new_id("upload")) as incoming:
        try:
            async for chunk in request.stream():
                incoming.write(chunk)
            path = await offload.run(incoming.prove)
        except SegmentSizeError as error:
            raise ParcelTooLarge(f"a parcel has at most {PARCEL_BYTES_MAX} bytes") from error
        except SegmentHashError as error:
            raise ParcelHashWrong(f"{error}; send the parcel again") from error
        header = await offload.run(lambda: _header(path))
        # Before it is kept: a parcel without a request takes no room.
        await services.transactions.read(lambda uow: scans.check_parcel(uow, vehicle_id, header))
        size_bytes = incoming.size_bytes
        try:
            await offload.run(lambda: store.keep(incoming))
        except SegmentStoreError as error:
            raise ScanStoreUnavailable(f"{error}; send the parcel again") from error
    return header, size_bytes


async def _kept(services: Services, vehicle_id: str, sha256: str) -> ScanParcel | None:
    """The parcel of an upload that is repeated."""
    known = await services.transactions.read(lambda uow: uow.scans.parcel(sha256))
    if known is None:
        return None
    if known.vehicle_id != vehicle_id:
        raise SignatureWrong(f"the scans were taken by {known.vehicle_id}, not by {vehicle_id}")
    try:
        return known if await services.offload.run(lambda: services.scans.has(sha256)) else None
    except SegmentStoreError as error:
        raise ScanStoreUnavailable(f"{error}; send the parcel again") from error


def _header(path: Path) -> ParcelHeader:
    try:
        return checked_parcel(path)
    except ParcelError as error:
        raise ParcelUnreadable(str(error).rstrip(".")) from error
