"""Operators' announcements as rows."""

from datetime import datetime

from server.domain.service.announcements import Announcement, Audience
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.keyset import rows_after
from server.store.repository import AnyRow, Repository
from server.usecases.ports.records import AnnouncementPosition

_announcement = tables.announcements.c


class SqlAnnouncementRepository(Repository):
    def get(self, announcement_id: str) -> Announcement | None:
        row = self._find(tables.announcements, announcement_id=announcement_id)
        return None if row is None else _from_row(row)

    def standing(self, now: datetime) -> tuple[Announcement, ...]:
        chosen = self._select(
            tables.announcements,
            _announcement.ended_at.is_(None),
            _announcement.ends_at.is_(None) | (_announcement.ends_at > now),
        )
        ordered = chosen.order_by(_announcement.starts_at, _announcement.announcement_id)
        return tuple(_from_row(row) for row in self._many(ordered))

    def newest(self, limit: int, after: AnnouncementPosition | None = None) -> tuple[Announcement, ...]:
        statement = self._select(tables.announcements)
        if after is not None:
            order = ((_announcement.made_at, True), (_announcement.announcement_id, True))
            statement = statement.where(rows_after(order, after))
        ordered = statement.order_by(_announcement.made_at.desc(), _announcement.announcement_id.desc())
        return tuple(_from_row(row) for row in self._many(ordered.limit(limit)))

    def add(self, announcement: Announcement) -> None:
        self._insert(tables.announcements, _to_row(announcement))

    def save(self, announcement: Announcement) -> None:
        row, key = _to_row(announcement), announcement.announcement_id
        self._change(tables.announcements, row, announcement_id=key)


def _to_row(announcement: Announcement) -> dict[str, object]:
    return {
        "announcement_id": announcement.announcement_id,
        "text_zh": announcement.text_zh,
        "text_en": announcement.text_en,
        "starts_at": announcement.starts_at,
        "ends_at": announcement.ends_at,
        "audience": str(announcement.audience),
        "stop_ids": to_json(announcement.stop_ids),
        "vehicle_ids": to_json(announcement.vehicle_ids),
        "made_by": announcement.made_by,
        "made_at": announcement.made_at,
        "sent_at": announcement.sent_at,
        "ended_by": announcement.ended_by,
        "ended_at": announcement.ended_at,
    }


def _from_row(row: AnyRow) -> Announcement:
    return Announcement(
        campus_id=row.campus_id,
        announcement_id=row.announcement_id,
        text_zh=row.text_zh,
        text_en=row.text_en,
        starts_at=row.starts_at,
        ends_at=row.ends_at,
        audience=Audience(row.audience),
        stop_ids=from_json(row.stop_ids, tuple[str, ...]),
        vehicle_ids=from_json(row.vehicle_ids, tuple[str, ...]),
        made_by=row.made_by,
        made_at=row.made_at,
        sent_at=row.sent_at,
        ended_by=row.ended_by,
        ended_at=row.ended_at,
    )
