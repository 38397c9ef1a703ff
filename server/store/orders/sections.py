"""Sections held by vehicles, as rows."""

from collections.abc import Sequence, Set
from typing import Any

from sqlalchemy import Connection, Select

from server.domain.orders.sections import HeldSection, Occupancy
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.counters import Counters
from server.store.repository import Repository
from server.store.writing.campus_lock import CampusLock

_FENCE = "fence"
_held = tables.held_sections.c
_route = tables.section_routes.c


class SqlSectionRepository(Repository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock | None) -> None:
        super().__init__(connection, campus_id, lock)
        self._counters = Counters(connection, campus_id, lock)

    def all(self) -> tuple[Occupancy, ...]:
        return self._read(self._select(tables.held_sections), self._select(tables.section_routes))

    def of(self, vehicle_ids: Set[str]) -> dict[str, Occupancy]:
        """Of those that are placed, by vehicle id."""
        held = self._select(tables.held_sections, _held.vehicle_id.in_(vehicle_ids))
        routes = self._select(tables.section_routes, _route.vehicle_id.in_(vehicle_ids))
        return {occupancy.vehicle_id: occupancy for occupancy in self._read(held, routes)}

    def _read(self, held_sections: Select[Any], section_routes: Select[Any]) -> tuple[Occupancy, ...]:
        held: dict[str, list[HeldSection]] = {}
        for row in self._many(held_sections.order_by(_held.fence)):
            held.setdefault(row.vehicle_id, []).append(HeldSection(row.section_id, row.fence))
        routes = {row.vehicle_id: row for row in self._many(section_routes)}
        return tuple(
            Occupancy(
                vehicle_id,
                tuple(sections),
                from_json(routes[vehicle_id].ahead, tuple[str, ...]),
                routes[vehicle_id].goal,
            )
            for vehicle_id, sections in sorted(held.items())
        )

    def held_by(self, vehicle_id: str) -> tuple[HeldSection, ...]:
        occupancy = self._of(vehicle_id)
        return () if occupancy is None else occupancy.held

    def save(self, occupancy: Occupancy) -> None:
        self._write([(self._of(occupancy.vehicle_id), occupancy)])

    def _of(self, vehicle_id: str) -> Occupancy | None:
        rows = self._many(self._select(tables.held_sections, _held.vehicle_id == vehicle_id))
        held = tuple(HeldSection(row.section_id, row.fence) for row in rows)
        return Occupancy(vehicle_id, held, ()) if held else None

    def _write(self, changes: Sequence[tuple[Occupancy | None, Occupancy]]) -> None:
        """What has changed: of each vehicle the stored occupancy and the new one."""
        gone: list[int] = []
        held: list[dict[str, object]] = []
        for before, after in changes:
            known = frozenset() if before is None else frozenset(before.held)
            gone += sorted(section.fence for section in known.difference(after.held))
            held += [
                {"fence": s.fence, "vehicle_id": after.vehicle_id, "section_id": s.section_id}
                for s in after.held
                if s not in known
            ]
        routes = [
            {"vehicle_id": after.vehicle_id, "ahead": to_json(after.ahead), "goal": after.goal}
            for _, after in changes
        ]
        self._remove_all(tables.held_sections, [{"fence": fence} for fence in gone])
        self._put_all(tables.held_sections, held)
        self._put_all(tables.section_routes, routes)

    def flush(self) -> None:
        """Write what waits for the end of the transaction."""

    def remove(self, vehicle_id: str) -> None:
        self._delete(tables.held_sections, _held.vehicle_id == vehicle_id)
        self._delete(tables.section_routes, _route.vehicle_id == vehicle_id)

    def next_fence(self) -> int:
        return self._counters.next(_FENCE)

    def skip_fences(self, count: int) -> None:
        self._counters.next(_FENCE, count)
