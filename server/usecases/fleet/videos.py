"""Video of vehicles: entered when it comes, found by the run's time, forgotten after `video_days`."""

from datetime import datetime, timedelta

from contract.video import SegmentName
from server.domain.errors import VideoSpanInvalid, VideoUnknown
from server.domain.fleet.videos import VideoSegment
from server.domain.instants import moment_of_ns
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

SPAN_MAX = timedelta(hours=6)
FORGOTTEN_AT_A_TIME = 200


def add_segment(uow: UnitOfWork, vehicle_id: str, name: SegmentName, sha256: str, size_bytes: int) -> bool:
    """Enter a segment whose bytes are kept; False for one that is known. Raises VehicleUnknown."""
    enrolled_vehicle(uow, vehicle_id)
    if uow.videos.segment(sha256) is not None:
        return False
    uow.videos.add(
        VideoSegment(
            campus_id=uow.campus_id,
            sha256=sha256,
            vehicle_id=vehicle_id,
            camera=name.camera,
            begins_at=moment_of_ns(name.utc_ns),
            ends_at=moment_of_ns(name.end_utc_ns),
            stamp_ns=name.stamp_ns,
            size_bytes=size_bytes,
            received_at=uow.now,
        )
    )
    return True


def segments_between(
    uow: UnitOfWork, vehicle_id: str, begin: datetime, end: datetime
) -> tuple[VideoSegment, ...]:
    """What has come of a vehicle's cameras for a span. Raises VehicleUnknown, VideoSpanInvalid."""
    enrolled_vehicle(uow, vehicle_id)
    if not timedelta(0) <= end - begin <= SPAN_MAX:
        raise VideoSpanInvalid("give a span of at most six hours, its beginning first")
    return uow.videos.between(vehicle_id, begin, end)


def segment_of(uow: UnitOfWork, sha256: str) -> VideoSegment:
    """Raises VideoUnknown."""
    segment = uow.videos.segment(sha256)
    if segment is None:
        raise VideoUnknown(f"no video segment has the hash {sha256}")
    return segment


def outdated(uow: UnitOfWork) -> tuple[str, ...]:
    """Hashes of those that came longer ago than `video_days`: some at a time."""
    before = uow.now - timedelta(days=uow.rules.video_days)
    return tuple(one.sha256 for one in uow.videos.received_before(before, FORGOTTEN_AT_A_TIME))


def forget(uow: UnitOfWork, sha256: str) -> None:
    """Its bytes are deleted."""
    uow.videos.remove(sha256)
