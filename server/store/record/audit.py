"""The audit log as rows. Nothing is changed but the address, which is forgotten after a while."""

from datetime import datetime

from sqlalchemy import select

from server.domain.record.audit import AuditAction, AuditEntry, Head
from server.store import tables
from server.store.repository import AnyRow, Repository

_entry = tables.audit_entries.c
_head = select(_entry.number, _entry.sha256).order_by(_entry.number.desc()).limit(1)


class SqlAuditRepository(Repository):
    def head(self) -> Head:
        row = self._connection.execute(_head.where(_entry.campus_id == self._campus_id)).first()
        return Head() if row is None else Head(row.number, row.sha256)

    def add(self, entry: AuditEntry) -> None:
        self._insert(
            tables.audit_entries,
            {
                "number": entry.number,
                "happened_at": entry.happened_at,
                "kind": entry.kind,
                "made_by": entry.by,
                "action": entry.action.action,
                "subject": entry.action.subject,
                "detail": entry.action.detail,
                "outcome": entry.action.outcome,
                "command_id": entry.action.command_id,
                "address": entry.address,
                "salt": entry.salt,
                "address_sha256": entry.address_sha256,
                "previous_sha256": entry.previous_sha256,
                "sha256": entry.sha256,
            },
        )

    def newest(
        self,
        limit: int,
        before: int | None = None,
        by: str | None = None,
        action: str | None = None,
        subject: str | None = None,
    ) -> tuple[AuditEntry, ...]:
        statement = self._select(tables.audit_entries)
        if before is not None:
            statement = statement.where(_entry.number < before)
        for column, value in ((_entry.made_by, by), (_entry.action, action), (_entry.subject, subject)):
            if value is not None:
                statement = statement.where(column == value)
        rows = self._many(statement.order_by(_entry.number.desc()).limit(limit))
        return tuple(_from_row(row) for row in rows)

    def following(self, number: int, limit: int) -> tuple[AuditEntry, ...]:
        statement = self._select(tables.audit_entries, _entry.number > number)
        rows = self._many(statement.order_by(_entry.number).limit(limit))
        return tuple(_from_row(row) for row in rows)

    def forget_addresses_before(self, moment: datetime) -> int:
        return self._update(
            tables.audit_entries, {"address": "", "salt": ""}, _entry.happened_at < moment, _entry.salt != ""
        )


def _from_row(row: AnyRow) -> AuditEntry:
    return AuditEntry(
        campus_id=row.campus_id,
        number=row.number,
        happened_at=row.happened_at,
        kind=row.kind,
        by=row.made_by,
        action=AuditAction(row.action, row.subject, row.detail, row.outcome, row.command_id),
        address=row.address,
        salt=row.salt,
        address_sha256=row.address_sha256,
        previous_sha256=row.previous_sha256,
        sha256=row.sha256,
    )
