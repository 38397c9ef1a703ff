"""Video of vehicles' cameras: sent by vehicles by content hash, watched by operators with the role for it."""

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Request, Response
from starlette.responses import FileResponse

from contract.video import SEGMENT_HEADER, WEBM_BEGINS, name_of, signed_video
from server.api.commands import WatchVideoCommand
from server.api.formats import Sha256, VehicleId
from server.api.problems import (
    SignatureWrong,
    VideoHashWrong,
    VideoStoreUnavailable,
    VideoTooLarge,
    VideoUnreadable,
    problems,
)
from server.api.security.access import LOOKING_REFUSALS, OPERATOR_REFUSALS, Actor, looking
from server.api.security.permissions import WATCH_VIDEO
from server.api.security.vehicle_signature import Signature, SigningVehicle, check_signature
from server.api.services import InjectedServices, Services
from server.api.videos.schemas import VideoSegmentView, VideoSpan, VideoView, video_segment_view
from server.domain.errors import KeyUnknown, VehicleUnknown, VideoSpanInvalid, VideoUnknown
from server.domain.fleet.videos import VideoSegment
from server.store.segments.choice import VIDEO_BYTES_MAX
from server.store.segments.incoming import SegmentHashError, SegmentSizeError
from server.store.segments.segment_store import SegmentStoreError
from server.usecases.fleet import videos
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(tags=["videos"])

MEDIA_TYPE = "video/webm"
BINARY = {"schema": {"type": "string", "format": "binary"}}
Watcher = Annotated[Actor, Depends(looking(WATCH_VIDEO))]
GivenName = Annotated[
    str, Header(alias=SEGMENT_HEADER, max_length=100, description="The segment's file name.")
]


@router.put(
    "/video-segments/{sha256}",
    operation_id="put_video_segment",
    status_code=201,
    max_body_size=VIDEO_BYTES_MAX,
    responses=problems(
        VideoHashWrong,
        VideoUnreadable,
        VideoTooLarge,
        VideoStoreUnavailable,
        SignatureWrong,
        KeyUnknown,
        VehicleUnknown,
    )
    | {200: {"model": VideoSegmentView, "description": "The segment was there already."}},
    openapi_extra={"requestBody": {"required": True, "content": {"application/octet-stream": BINARY}}},
)
async def put_video_segment(
    sha256: Sha256,
    request: Request,
    response: Response,
    services: InjectedServices,
    vehicle_id: SigningVehicle,
    signature: Signature,
    given_name: GivenName,
) -> VideoSegmentView:
    """A segment of one camera, by the SHA-256 of its bytes. A repeat is harmless."""
    await check_signature(services, vehicle_id, signature, signed_video(vehicle_id, sha256, given_name))
    name = name_of(given_name)
    if name is None or name.length_ms is None:
        raise VideoUnreadable(f"{given_name!r} is not the name of a finished segment")
    known = await services.transactions.read(lambda uow: uow.videos.segment(sha256))
    if known is None or not await _is_kept(services, sha256):
        size_bytes = await _receive(services, request, sha256)
        add = await services.transactions.run(
            lambda uow: videos.add_segment(uow, vehicle_id, name, sha256, size_bytes)
        )
        response.status_code = 201 if add else 200
    else:
        response.status_code = 200
    kept = await services.transactions.read(lambda uow: videos.segment_of(uow, sha256))
    if kept.vehicle_id != vehicle_id:
        raise SignatureWrong(f"the segment was recorded by {kept.vehicle_id}, not by {vehicle_id}")
    return video_segment_view(kept)


@router.post(
    "/vehicles/{vehicle_id}/video-views",
    operation_id="watch_video",
    responses=problems(VehicleUnknown, VideoSpanInvalid, *OPERATOR_REFUSALS),
)
async def watch_video(vehicle_id: VehicleId, span: VideoSpan, command: WatchVideoCommand) -> VideoView:
    """The segments that have come for a span, to be played. Who looks is in the audit log."""

    def work(uow: UnitOfWork) -> VideoView:
        found = videos.segments_between(uow, vehicle_id, span.begin, span.end)
        return VideoView(segments=[video_segment_view(one) for one in found])

    told = f"{span.begin.isoformat(timespec='seconds')} to {span.end.isoformat(timespec='seconds')}"
    return await command.about(vehicle_id, told).transact(VideoView, work)


@router.get(
    "/video-segments/{sha256}",
    operation_id="get_video_segment",
    response_class=FileResponse,
    responses=problems(VideoUnknown, VideoStoreUnavailable, *LOOKING_REFUSALS)
    | {200: {"description": "WebM; ranges of it are answered too.", "content": {MEDIA_TYPE: BINARY}}},
)
async def get_video_segment(sha256: Sha256, services: InjectedServices, _: Watcher) -> FileResponse:
    """A segment's file."""
    segment = await services.transactions.read(lambda uow: videos.segment_of(uow, sha256))
    path = await _fetched(services, sha256)
    if path is None:
        raise VideoUnknown(f"the bytes of video segment {sha256} are no longer kept")
    return FileResponse(
        path, media_type=MEDIA_TYPE, filename=_file_name(segment), content_disposition_type="inline"
    )


def _file_name(segment: VideoSegment) -> str:
    return f"{segment.vehicle_id}-{segment.camera}-{segment.begins_at:%Y%m%dT%H%M%SZ}.webm"


async def _receive(services: Services, request: Request, sha256: str) -> int:
    """The size of the segment, of which all bytes are kept now."""
    store, offload = services.videos, services.offload
    try:
        with store.receive(sha256, services.ids.new_id("upload")) as incoming:
            async for chunk in request.stream():
                incoming.write(chunk)
            path = await offload.run(incoming.prove)
            if not await offload.run(lambda: _is_webm(path)):
                raise VideoUnreadable("the bytes are no WebM file")
            await offload.run(lambda: store.keep(incoming))
            return incoming.size_bytes
    except SegmentSizeError as error:
        raise VideoTooLarge(f"a video segment has at most {VIDEO_BYTES_MAX} bytes") from error
    except SegmentHashError as error:
        raise VideoHashWrong(f"{error}; send the segment again") from error
    except (SegmentStoreError, OSError) as error:
        raise VideoStoreUnavailable(f"the upload cannot be kept now ({error}); send it again") from error


async def _is_kept(services: Services, sha256: str) -> bool:
    try:
        return await services.offload.run(lambda: services.videos.has(sha256))
    except SegmentStoreError as error:
        raise VideoStoreUnavailable(f"{error}; send the segment again") from error


async def _fetched(services: Services, sha256: str) -> Path | None:
    try:
        return await services.offload.run(lambda: services.videos.fetch(sha256))
    except (SegmentStoreError, OSError) as error:
        raise VideoStoreUnavailable(f"{error}; try again later") from error


def _is_webm(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(len(WEBM_BEGINS)) == WEBM_BEGINS
