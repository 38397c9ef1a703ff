"""Campus maps as rows."""

from sqlalchemy import Connection, select

from server.domain.maps import StoredMap
from server.store import tables
from server.store.repository import Repository

_map = tables.maps.c


class Maps(Repository):
    def get(self, map_version: str) -> StoredMap | None:
        row = self._find(tables.maps, map_version=map_version)
        if row is None:
            return None
        return StoredMap(row.campus_id, row.map_version, row.name, row.content, row.added_at, row.active)

    def active_version(self) -> str | None:
        return self._connection.execute(
            select(_map.map_version).where(_map.campus_id == self._campus_id, _map.active.is_(True))
        ).scalar_one_or_none()

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
