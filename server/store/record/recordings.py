"""Recordings that operators asked for, as rows."""

from datetime import datetime

from server.domain.record.recordings import Recording, VehicleMoment
from server.store import tables
from server.store.keyset import rows_after
from server.store.repository import AnyRow, Repository
from server.usecases.ports.records import RecordingPosition

_recording = tables.recordings.c


class SqlRecordingRepository(Repository):
    def get(self, recording_id: str) -> Recording | None:
        row = self._find(tables.recordings, recording_id=recording_id)
        return None if row is None else _from_row(row)

    def of_command(self, command_id: str) -> Recording | None:
        found = self.get(command_id)
        if found is not None:
            return found
        row = self._find(tables.recordings, stop_id=command_id)
        return None if row is None else _from_row(row)

    def newest_of(self, vehicle_id: str) -> Recording | None:
        found = self.newest(vehicle_id=vehicle_id, limit=1)
        return found[0] if found else None

    def newest(
        self, vehicle_id: str | None = None, limit: int = 100, after: RecordingPosition | None = None
    ) -> tuple[Recording, ...]:
        statement = self._select(tables.recordings)
        if vehicle_id is not None:
            statement = statement.where(_recording.vehicle_id == vehicle_id)
        if after is not None:
            order = ((_recording.started_at, True), (_recording.recording_id, True))
            statement = statement.where(rows_after(order, after))
        ordered = statement.order_by(_recording.started_at.desc(), _recording.recording_id.desc())
        return tuple(_from_row(row) for row in self._many(ordered.limit(limit)))

    def of_time(self, vehicle_id: str, since: datetime, until: datetime) -> tuple[Recording, ...]:
        chosen = self._select(
            tables.recordings,
            _recording.vehicle_id == vehicle_id,
            _recording.started_at < until,
            _recording.stopped_at.is_(None) | (_recording.stopped_at >= since),
        )
        ordered = chosen.order_by(_recording.started_at, _recording.recording_id)
        return tuple(_from_row(row) for row in self._many(ordered))

    def save(self, recording: Recording) -> None:
        begun, ended = recording.begun, recording.ended
        self._put(
            tables.recordings,
            {
                "recording_id": recording.recording_id,
                "vehicle_id": recording.vehicle_id,
                "name": recording.name,
                "started_at": recording.started_at,
                "started_by": recording.started_by,
                "state": recording.state,
                "stop_id": recording.stop_id,
                "stopped_at": recording.stopped_at,
                "stopped_by": recording.stopped_by,
                "begun_boot": "" if begun is None else begun.boot_id,
                "begun_ns": 0 if begun is None else begun.stamp_ns,
                "ended_boot": "" if ended is None else ended.boot_id,
                "ended_ns": 0 if ended is None else ended.stamp_ns,
                "detail": recording.detail,
            },
        )


def _from_row(row: AnyRow) -> Recording:
    return Recording(
        campus_id=row.campus_id,
        recording_id=row.recording_id,
        vehicle_id=row.vehicle_id,
        name=row.name,
        started_at=row.started_at,
        started_by=row.started_by,
        state=row.state,
        stop_id=row.stop_id,
        stopped_at=row.stopped_at,
        stopped_by=row.stopped_by,
        begun=VehicleMoment(row.begun_boot, row.begun_ns) if row.begun_boot else None,
        ended=VehicleMoment(row.ended_boot, row.ended_ns) if row.ended_boot else None,
        detail=row.detail,
    )
