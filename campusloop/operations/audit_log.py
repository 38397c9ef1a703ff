"""Follows the audit log of a database without its server: whether each entry follows the one before."""

from collections.abc import Iterator
from dataclasses import dataclass

from sqlalchemy import Engine, select

from server.domain.record.audit import AuditEntry, Break, Head, first_break
from server.store import tables
from server.store.record.audit import SqlAuditRepository

_ENTRIES_AT_A_TIME = 1_000


@dataclass(frozen=True, slots=True)
class AuditFinding:
    """Of one campus. broken: the first entry that does not belong; head: the last one that does."""

    campus_id: str
    broken: Break | None
    head: Head


def audit_findings(engine: Engine, noted: Head | None = None) -> tuple[AuditFinding, ...]:
    """For each campus of the database. noted: a head from the server's log; the chain must go through it."""
    entries = tables.audit_entries
    with engine.connect() as connection:
        campuses = connection.execute(select(entries.c.campus_id).distinct().order_by(entries.c.campus_id))
        return tuple(
            _finding(campus_id, SqlAuditRepository(connection, campus_id, None), noted)
            for campus_id in campuses.scalars().all()
        )


def _finding(campus_id: str, repository: SqlAuditRepository, noted: Head | None) -> AuditFinding:
    broken, head = first_break(_all(repository), Head())
    if broken is None and noted is not None:
        at_noted = repository.following(noted.number - 1, 1)
        if not at_noted or at_noted[0].number != noted.number:
            broken = Break(noted.number, "it was noted elsewhere, and the log has no such entry")
        elif at_noted[0].sha256 != noted.sha256:
            broken = Break(noted.number, "it is another entry than was noted elsewhere")
    return AuditFinding(campus_id, broken, head)


def _all(repository: SqlAuditRepository) -> Iterator[AuditEntry]:
    number = 0
    while entries := repository.following(number, _ENTRIES_AT_A_TIME):
        yield from entries
        number = entries[-1].number
