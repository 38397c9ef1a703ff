"""Localization maps as rows: facts, manifests, and which tiles are kept."""

from collections.abc import Collection, Mapping
from dataclasses import asdict
from datetime import datetime

from sqlalchemy import select

from contract.localization_manifest import LocalizationMapKind
from contract.roads.model import Origin
from server.domain.roads.localization_maps import LocalizationMap
from server.store import tables
from server.store.repository import AnyRow, Repository

_map = tables.localization_maps.c
_tile = tables.localization_tiles.c
_FACTS = [column for column in _map if column.name != "manifest"]


class SqlLocalizationMapRepository(Repository):
    def get(self, map_version: str) -> LocalizationMap | None:
        query = select(*_FACTS).where(_map.campus_id == self._campus_id, _map.map_version == map_version)
        row = self._connection.execute(query).first()
        return None if row is None else _from_row(row)

    def manifest(self, map_version: str) -> bytes | None:
        query = select(_map.manifest).where(
            _map.campus_id == self._campus_id, _map.map_version == map_version
        )
        return self._connection.execute(query).scalar_one_or_none()

    def all(self) -> tuple[LocalizationMap, ...]:
        query = select(*_FACTS).where(_map.campus_id == self._campus_id)
        rows = self._connection.execute(query.order_by(_map.published_at.desc(), _map.map_version))
        return tuple(_from_row(row) for row in rows)

    def in_force(self) -> Mapping[LocalizationMapKind, LocalizationMap]:
        query = select(*_FACTS).where(_map.campus_id == self._campus_id, _map.active.is_(True))
        return {found.kind: found for found in map(_from_row, self._connection.execute(query))}

    def add(self, stored: LocalizationMap, manifest: bytes) -> None:
        self._insert(tables.localization_maps, {**_to_row(stored), "manifest": manifest})

    def save(self, stored: LocalizationMap) -> None:
        self._change(tables.localization_maps, _to_row(stored), map_version=stored.map_version)

    def remove(self, map_version: str) -> None:
        self._delete(tables.localization_maps, _map.map_version == map_version)

    def kept_tiles(self) -> frozenset[str]:
        query = select(_tile.sha256).where(_tile.campus_id == self._campus_id)
        return frozenset(self._connection.execute(query).scalars())

    def is_kept(self, sha256: str) -> bool:
        return self._find(tables.localization_tiles, sha256=sha256) is not None

    def keep_tiles(self, sizes: Mapping[str, int], at: datetime) -> None:
        rows = [
            {"sha256": sha256, "size_bytes": size_bytes, "kept_at": at}
            for sha256, size_bytes in sorted(sizes.items())
        ]
        self._put_all(tables.localization_tiles, rows)

    def forget_tiles(self, sha256s: Collection[str]) -> None:
        self._remove_all(tables.localization_tiles, [{"sha256": sha256} for sha256 in sorted(sha256s)])


def _to_row(stored: LocalizationMap) -> dict[str, object]:
    row = asdict(stored)
    del row["campus_id"], row["origin"]
    return row | {"latitude_deg": stored.origin.latitude_deg, "longitude_deg": stored.origin.longitude_deg}


def _from_row(row: AnyRow) -> LocalizationMap:
    return LocalizationMap(
        campus_id=row.campus_id,
        map_version=row.map_version,
        kind=row.kind,
        origin=Origin(row.latitude_deg, row.longitude_deg),
        manifest_sha256=row.manifest_sha256,
        manifest_bytes=row.manifest_bytes,
        tile_count=row.tile_count,
        size_bytes=row.size_bytes,
        road_map_version=row.road_map_version,
        note=row.note,
        published_by=row.published_by,
        published_at=row.published_at,
        active=row.active,
        activated_by=row.activated_by,
        activated_at=row.activated_at,
    )
