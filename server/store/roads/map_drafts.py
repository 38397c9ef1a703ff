"""Drafts of maps as rows."""

from sqlalchemy import select

from server.domain.roads.maps import MapDraft
from server.store import tables
from server.store.repository import AnyRow, Repository

_draft = tables.map_drafts.c
_FACTS = [column for column in _draft if column.name != "content"]


class SqlMapDraftRepository(Repository):
    def get(self, draft_id: str) -> MapDraft | None:
        row = self._find(tables.map_drafts, draft_id=draft_id)
        return None if row is None else _from_row(row, row.content)

    def all(self) -> tuple[MapDraft, ...]:
        """By the newest change, without content: a map has some megabytes."""
        query = select(*_FACTS).where(_draft.campus_id == self._campus_id)
        rows = self._connection.execute(query.order_by(_draft.changed_at.desc(), _draft.draft_id))
        return tuple(_from_row(row, b"") for row in rows)

    def add(self, draft: MapDraft) -> None:
        self._insert(tables.map_drafts, _to_row(draft))

    def save(self, draft: MapDraft) -> None:
        self._change(tables.map_drafts, _to_row(draft), draft_id=draft.draft_id)

    def remove(self, draft_id: str) -> None:
        self._delete(tables.map_drafts, _draft.draft_id == draft_id)


def _to_row(draft: MapDraft) -> dict[str, object]:
    return {
        "draft_id": draft.draft_id,
        "name": draft.name,
        "revision": draft.revision,
        "based_on": draft.based_on,
        "made_by": draft.made_by,
        "made_at": draft.made_at,
        "changed_by": draft.changed_by,
        "changed_at": draft.changed_at,
        "content": draft.content,
    }


def _from_row(row: AnyRow, content: bytes) -> MapDraft:
    return MapDraft(
        row.campus_id,
        row.draft_id,
        row.name,
        row.revision,
        row.based_on,
        row.made_by,
        row.made_at,
        row.changed_by,
        row.changed_at,
        content,
    )
