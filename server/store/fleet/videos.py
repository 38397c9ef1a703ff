"""Video segments as rows; their bytes are in files."""

from datetime import datetime

from server.domain.fleet.videos import VideoSegment
from server.store import tables
from server.store.repository import AnyRow, Repository

_segment = tables.video_segments.c


class SqlVideoRepository(Repository):
    def segment(self, sha256: str) -> VideoSegment | None:
        row = self._find(tables.video_segments, sha256=sha256)
        return None if row is None else _segment_from_row(row)

    def between(self, vehicle_id: str, begin: datetime, end: datetime) -> tuple[VideoSegment, ...]:
        chosen = self._select(
            tables.video_segments,
            _segment.vehicle_id == vehicle_id,
            _segment.begins_at <= end,
            _segment.ends_at >= begin,
        )
        ordered = chosen.order_by(_segment.camera, _segment.begins_at, _segment.sha256)
        return tuple(_segment_from_row(row) for row in self._many(ordered))

    def received_before(self, moment: datetime, limit: int) -> tuple[VideoSegment, ...]:
        chosen = self._select(tables.video_segments, _segment.received_at < moment)
        ordered = chosen.order_by(_segment.received_at, _segment.sha256).limit(limit)
        return tuple(_segment_from_row(row) for row in self._many(ordered))

    def add(self, segment: VideoSegment) -> None:
        self._insert(
            tables.video_segments,
            {
                "sha256": segment.sha256,
                "vehicle_id": segment.vehicle_id,
                "camera": segment.camera,
                "begins_at": segment.begins_at,
                "ends_at": segment.ends_at,
                "stamp_ns": segment.stamp_ns,
                "size_bytes": segment.size_bytes,
                "received_at": segment.received_at,
            },
        )

    def remove(self, sha256: str) -> None:
        self._delete(tables.video_segments, _segment.sha256 == sha256)


def _segment_from_row(row: AnyRow) -> VideoSegment:
    return VideoSegment(
        campus_id=row.campus_id,
        sha256=row.sha256,
        vehicle_id=row.vehicle_id,
        camera=row.camera,
        begins_at=row.begins_at,
        ends_at=row.ends_at,
        stamp_ns=row.stamp_ns,
        size_bytes=row.size_bytes,
        received_at=row.received_at,
    )
