"""Road closures as rows."""

from server.domain.roads.closures import Closure, ClosureState
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository

_closure = tables.closures.c


class SqlClosureRepository(Repository):
    def get(self, closure_id: str) -> Closure | None:
        row = self._find(tables.closures, closure_id=closure_id)
        return None if row is None else _from_row(row)

    def standing(self) -> tuple[Closure, ...]:
        rows = self._many(
            self._select(tables.closures, _closure.state != str(ClosureState.OVER)).order_by(
                _closure.starts_at, _closure.closure_id
            )
        )
        return tuple(_from_row(row) for row in rows)

    def add(self, closure: Closure) -> None:
        self._insert(tables.closures, _to_row(closure))

    def save(self, closure: Closure) -> None:
        self._change(tables.closures, _to_row(closure), closure_id=closure.closure_id)


def _to_row(closure: Closure) -> dict[str, object]:
    return {
        "closure_id": closure.closure_id,
        "lane_ids": to_json(closure.lane_ids),
        "section_ids": to_json(closure.section_ids),
        "reason": closure.reason,
        "starts_at": closure.starts_at,
        "ends_at": closure.ends_at,
        "made_by": closure.made_by,
        "made_at": closure.made_at,
        "state": str(closure.state),
        "lifted_by": closure.lifted_by,
    }


def _from_row(row: AnyRow) -> Closure:
    return Closure(
        row.campus_id,
        row.closure_id,
        from_json(row.lane_ids, tuple[str, ...]),
        from_json(row.section_ids, tuple[str, ...]),
        row.reason,
        row.starts_at,
        row.ends_at,
        row.made_by,
        row.made_at,
        ClosureState(row.state),
        row.lifted_by,
    )
