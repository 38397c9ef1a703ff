"""Run segments: uploaded by vehicles by content hash, downloaded by operators."""

from pathlib import Path

from fastapi import APIRouter, Request, Response
from starlette.responses import FileResponse

from contract.runlog.extent import extent
from contract.runlog.indexed import logged_marks
from contract.runlog.reader import RunLogError, open_segment
from contract.runlog.records import RunHeader
from contract.wire.upload import signed_segment
from server.api.formats import Sha256
from server.api.problems import (
    SegmentHashWrong,
    SegmentStoreUnavailable,
    SegmentTooLarge,
    SegmentUnreadable,
    SignatureWrong,
    problems,
)
from server.api.runs.schemas import SegmentView, segment_view
from server.api.security.access import READER_REFUSALS, Reader
from server.api.security.vehicle_signature import Signature, SigningVehicle, check_signature
from server.api.services import InjectedServices, Services
from server.domain.errors import KeyUnknown, SegmentConflict, SegmentUnknown, VehicleUnknown
from server.domain.record.recordings import VehicleMoment
from server.domain.record.runs import Segment
from server.store.segments.incoming import SegmentHashError, SegmentSizeError
from server.store.segments.segment_store import SegmentStoreError
from server.usecases.record import runs

router = APIRouter(prefix="/runs/segments", tags=["runs"])

# Above every setting of segment_bytes_max, which is what counts.
SEGMENT_BYTES_LIMIT = 1 << 40
# A segment, and the commands to recordings that are marked in it.
Received = tuple[Segment, dict[str, VehicleMoment]]
MEDIA_TYPE = "application/octet-stream"


@router.put(
    "/{sha256}",
    operation_id="put_segment",
    status_code=201,
    max_body_size=SEGMENT_BYTES_LIMIT,
    responses=problems(
        SegmentHashWrong,
        SegmentUnreadable,
        SignatureWrong,
        KeyUnknown,
        VehicleUnknown,
        SegmentConflict,
        SegmentTooLarge,
        SegmentStoreUnavailable,
    )
    | {200: {"model": SegmentView, "description": "The segment was there already."}},
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def put_segment(
    sha256: Sha256,
    request: Request,
    response: Response,
    services: InjectedServices,
    vehicle_id: SigningVehicle,
    signature: Signature,
) -> SegmentView:
    """A finished segment, by the SHA-256 of its bytes. A repeat is harmless."""
    await check_signature(services, vehicle_id, signature, signed_segment(vehicle_id, sha256))
    known = await _kept(services, vehicle_id, sha256)
    if known is not None:
        response.status_code = 200
        return segment_view(known)
    segment, ends = await _receive(services, request, vehicle_id, sha256)
    if not await services.transactions.run(lambda uow: runs.add_segment(uow, segment, ends)):
        response.status_code = 200
    return segment_view(segment)


@router.get(
    "/{sha256}",
    operation_id="get_segment",
    response_class=FileResponse,
    responses=problems(SegmentUnknown, SegmentStoreUnavailable, *READER_REFUSALS)
    | {
        200: {
            "description": "The segment, as the vehicle wrote it.",
            "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def get_segment(sha256: Sha256, services: InjectedServices, _: Reader) -> FileResponse:
    """An MCAP file: open it in Foxglove, or run it again with `campusloop replay`."""
    segment = await services.transactions.read(lambda uow: runs.segment_of(uow, sha256))
    name = f"{segment.vehicle_id}-{segment.boot_id}-{segment.number:04d}.mcap"
    path = await fetched(services, sha256)
    if path is None:
        raise SegmentUnknown(f"the bytes of segment {sha256} are no longer kept")
    return FileResponse(path, filename=name, media_type=MEDIA_TYPE)


async def fetched(services: Services, sha256: str) -> Path | None:
    """The segment's file; None if it is not kept. Raises SegmentStoreUnavailable."""
    try:
        return await services.offload.run(lambda: services.segments.fetch(sha256))
    except SegmentStoreError as error:
        raise SegmentStoreUnavailable(str(error)) from error


async def _receive(services: Services, request: Request, vehicle_id: str, sha256: str) -> Received:
    """The segment, of which all bytes are kept now. Raises SegmentStoreUnavailable."""
    try:
        return await _received(services, request, vehicle_id, sha256)
    except OSError as error:
        raise SegmentStoreUnavailable(f"the upload cannot be kept now ({error}); send it again") from error


async def _received(services: Services, request: Request, vehicle_id: str, sha256: str) -> Received:
    """Raises OSError."""
    store, offload = services.segments, services.offload
    with store.receive(sha256, services.ids.new_id("upload")) as incoming:
        try:
            async for chunk in request.stream():
                incoming.write(chunk)
            path = await offload.run(incoming.prove)
        except SegmentSizeError as error:
            raise SegmentTooLarge(str(error)) from error
        except SegmentHashError as error:
            raise SegmentHashWrong(f"{error}; send the segment again") from error
        received = await offload.run(lambda: _described(services, path, vehicle_id, sha256))
        try:
            await offload.run(lambda: store.keep(incoming))
        except SegmentStoreError as error:
            raise SegmentStoreUnavailable(f"{error}; send the segment again") from error
    return received


async def _kept(services: Services, vehicle_id: str, sha256: str) -> Segment | None:
    """The segment of an upload that is repeated."""
    known = await services.transactions.read(lambda uow: uow.runs.segment(sha256))
    if known is None:
        return None
    if known.vehicle_id != vehicle_id:
        raise SignatureWrong(f"the segment was recorded by {known.vehicle_id}, not by {vehicle_id}")
    try:
        return known if await services.offload.run(lambda: services.segments.has(sha256)) else None
    except SegmentStoreError as error:
        raise SegmentStoreUnavailable(f"{error}; send the segment again") from error


def _described(services: Services, path: Path, vehicle_id: str, sha256: str) -> Received:
    try:
        header = open_segment(path).header
        first_ns, last_ns = extent(path)
    except RunLogError as error:
        raise SegmentUnreadable(f"{error.code}: not a run segment that can be used") from error
    if header.vehicle_id != vehicle_id:
        raise SignatureWrong(f"the segment was recorded by {header.vehicle_id}, not by {vehicle_id}")
    segment = Segment(
        campus_id=services.campus_id,
        vehicle_id=vehicle_id,
        boot_id=header.boot_id,
        number=header.segment,
        sha256=sha256,
        size_bytes=path.stat().st_size,
        first_ns=first_ns - header.utc_offset_ns,
        last_ns=last_ns - header.utc_offset_ns,
        received_at=services.clock.now(),
    )
    return segment, _recording_ends(path, header)


def _recording_ends(path: Path, header: RunHeader) -> dict[str, VehicleMoment]:
    """Where recordings begin and end in the sound part of a segment, by the vehicle's clock."""
    ends: dict[str, VehicleMoment] = {}
    try:
        for log_ns, mark in logged_marks(path):
            if mark.name != "mark":
                ends[mark.mark_id] = VehicleMoment(header.boot_id, log_ns - header.utc_offset_ns)
    except RunLogError as error:
        if error.code not in ("truncated", "damaged"):
            raise
    return ends
