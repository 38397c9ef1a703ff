"""Where every vehicle was: telemetry in batches, bounded by its age."""

from collections.abc import Sequence
from datetime import datetime

from server.domain.fleet.vehicles import StatusReport
from server.store import tables
from server.store.repository import Repository
from server.usecases.ports.views import HistoryPoint

_point = tables.history.c


class SqlHistoryRepository(Repository):
    def add(self, reports: Sequence[StatusReport]) -> None:
        """One statement for the whole batch; a repeated stamp is kept once."""
        self._add_missing(
            tables.history,
            [
                {
                    "vehicle_id": report.vehicle_id,
                    "boot_id": report.boot_id,
                    "stamp_ns": report.status.stamp_ns,
                    "received_at": report.received_at,
                    "x_m": report.status.pose_map.x_m,
                    "y_m": report.status.pose_map.y_m,
                    "yaw_rad": report.status.pose_map.yaw_rad,
                    "speed_mps": report.status.speed_mps,
                    "mode": report.status.mode,
                    "battery_ratio": report.status.battery_ratio,
                }
                for report in reports
            ],
        )

    def between(
        self, vehicle_id: str, since: datetime, until: datetime, limit: int
    ) -> tuple[HistoryPoint, ...]:
        rows = self._many(
            self._select(
                tables.history,
                _point.vehicle_id == vehicle_id,
                _point.received_at >= since,
                _point.received_at < until,
            )
            .order_by(_point.received_at, _point.boot_id, _point.stamp_ns)
            .limit(limit)
        )
        return tuple(
            HistoryPoint(
                row.vehicle_id,
                row.boot_id,
                row.received_at,
                row.stamp_ns,
                row.x_m,
                row.y_m,
                row.yaw_rad,
                row.speed_mps,
                row.mode,
                row.battery_ratio,
            )
            for row in rows
        )

    def forget_before(self, moment: datetime) -> int:
        """How many points were dropped."""
        return self._delete(tables.history, _point.received_at < moment)
