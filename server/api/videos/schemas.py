"""Video segments as operators see them."""

from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from server.api.formats import Moment
from server.domain.fleet.videos import VideoSegment

SEGMENT_EXAMPLE: JsonDict = {
    "sha256": 64 * "a",
    "vehicle_id": "shuttle-1",
    "camera": "front",
    "begins_at": "2026-09-01T08:15:00Z",
    "ends_at": "2026-09-01T08:16:00Z",
    "size_bytes": 6_100_000,
}


class VideoSpan(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"begin": "2026-09-01T08:15:00Z", "end": "2026-09-01T08:20:00Z"}},
    )

    begin: Moment
    end: Moment


class VideoSegmentView(BaseModel):
    """One file of one camera."""

    model_config = ConfigDict(json_schema_extra={"example": SEGMENT_EXAMPLE})

    sha256: str
    vehicle_id: str
    camera: str
    begins_at: datetime = Field(description="Of its first picture, by the vehicle's clock, as in its run.")
    ends_at: datetime
    size_bytes: int


class VideoView(BaseModel):
    """What has come of a vehicle's cameras for a span, by camera and time."""

    model_config = ConfigDict(json_schema_extra={"example": {"segments": [SEGMENT_EXAMPLE]}})

    segments: list[VideoSegmentView]


def video_segment_view(segment: VideoSegment) -> VideoSegmentView:
    return VideoSegmentView(
        sha256=segment.sha256,
        vehicle_id=segment.vehicle_id,
        camera=segment.camera,
        begins_at=segment.begins_at,
        ends_at=segment.ends_at,
        size_bytes=segment.size_bytes,
    )
