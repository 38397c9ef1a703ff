"""Campus maps as rows."""

from functools import lru_cache

from sqlalchemy import Connection, bindparam, exists, select

from server.domain.roads.closures import ClosureState
from server.domain.roads.maps import ActiveMap, MapVersion, StoredMap
from server.store import tables
from server.store.columns import from_json
from server.store.repository import Repository

_map = tables.maps.c
_closure = tables.closures.c
_STANDING = [str(ClosureState.SCHEDULED), str(ClosureState.IN_FORCE)]
# Asked in every transaction, so that the three questions are one statement, made once.
_ACTIVE = select(
    _map.map_version,
    exists().where(_closure.campus_id == bindparam("campus_id"), _closure.state.in_(_STANDING)),
    select(tables.travel_time_factors.c.factors)
    .where(tables.travel_time_factors.c.campus_id == bindparam("campus_id"))
    .scalar_subquery(),
).where(_map.campus_id == bindparam("campus_id"), _map.active.is_(True))


@lru_cache(maxsize=8)
def _factors(text: str) -> tuple[float, ...]:
    return from_json(text, tuple[float, ...])


class SqlMapRepository(Repository):
    def get(self, map_version: str) -> StoredMap | None:
        row = self._find(tables.maps, map_version=map_version)
        if row is None:
            return None
        return StoredMap(row.campus_id, row.map_version, row.name, row.content, row.added_at, row.active)

    def active_version(self) -> str | None:
        return self.active().map_version

    def active(self) -> ActiveMap:
        row = self._connection.execute(_ACTIVE, {"campus_id": self._campus_id}).one_or_none()
        if row is None:
            return ActiveMap(None, False, None)
        return ActiveMap(row[0], bool(row[1]), None if row[2] is None else _factors(row[2]))

    def versions(self) -> tuple[MapVersion, ...]:
        columns = (_map.map_version, _map.name, _map.added_at, _map.active)
        query = select(*columns).where(_map.campus_id == self._campus_id)
        rows = self._connection.execute(query.order_by(_map.added_at.desc(), _map.map_version))
        return tuple(MapVersion(row.map_version, row.name, row.added_at, row.active) for row in rows)

    def add(self, stored: StoredMap) -> None:
        self._insert(
            tables.maps,
            {
                "map_version": stored.map_version,
                "name": stored.name,
                "content": stored.content,
                "added_at": stored.added_at,
                "active": stored.active,
            },
        )

    def activate(self, map_version: str) -> None:
        self._update(tables.maps, {"active": False}, _map.active.is_(True))
        self._update(tables.maps, {"active": True}, _map.map_version == map_version)


def campuses(connection: Connection) -> tuple[str, ...]:
    """Every campus that has a map, in order: a database may hold several."""
    return tuple(connection.execute(select(_map.campus_id).distinct().order_by(_map.campus_id)).scalars())
