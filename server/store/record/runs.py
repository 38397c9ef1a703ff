"""Runs and their segments as rows; the segments' bytes are in files."""

from server.domain.record.runs import Run, Segment
from server.store import tables
from server.store.repository import AnyRow, Repository

_run = tables.runs.c
_segment = tables.segments.c


class SqlRunRepository(Repository):
    def get(self, vehicle_id: str, boot_id: str) -> Run | None:
        row = self._find(tables.runs, vehicle_id=vehicle_id, boot_id=boot_id)
        return None if row is None else self.with_segments(row)

    def add(self, run: Run) -> None:
        self._insert(
            tables.runs,
            {
                "vehicle_id": run.vehicle_id,
                "boot_id": run.boot_id,
                "started_at": run.started_at,
                "software": run.software,
                "stack": run.stack,
                "map_version": run.map_version,
            },
        )

    def segment(self, sha256: str) -> Segment | None:
        row = self._find(tables.segments, sha256=sha256)
        return None if row is None else _segment_from_row(row)

    def segments_at(self, vehicle_id: str, stamp_ns: int) -> tuple[Segment, ...]:
        chosen = self._select(
            tables.segments,
            _segment.vehicle_id == vehicle_id,
            _segment.first_ns <= stamp_ns,
            _segment.last_ns >= stamp_ns,
        )
        return tuple(_segment_from_row(row) for row in self._many(chosen.order_by(_segment.received_at)))

    def add_segment(self, segment: Segment) -> None:
        self._insert(
            tables.segments,
            {
                "sha256": segment.sha256,
                "vehicle_id": segment.vehicle_id,
                "boot_id": segment.boot_id,
                "number": segment.number,
                "size_bytes": segment.size_bytes,
                "first_ns": segment.first_ns,
                "last_ns": segment.last_ns,
                "received_at": segment.received_at,
            },
        )

    def with_segments(self, row: AnyRow) -> Run:
        segments = self._many(
            self._select(
                tables.segments, _segment.vehicle_id == row.vehicle_id, _segment.boot_id == row.boot_id
            ).order_by(_segment.number)
        )
        return Run(
            campus_id=row.campus_id,
            vehicle_id=row.vehicle_id,
            boot_id=row.boot_id,
            started_at=row.started_at,
            software=row.software,
            stack=row.stack,
            map_version=row.map_version,
            segments=tuple(_segment_from_row(segment) for segment in segments),
        )


def _segment_from_row(row: AnyRow) -> Segment:
    return Segment(
        campus_id=row.campus_id,
        vehicle_id=row.vehicle_id,
        boot_id=row.boot_id,
        number=row.number,
        sha256=row.sha256,
        size_bytes=row.size_bytes,
        first_ns=row.first_ns,
        last_ns=row.last_ns,
        received_at=row.received_at,
    )
