"""Plans as rows, each change compared with the version that its writer read."""

from collections.abc import Set

from sqlalchemy import Connection

from server.domain.errors import PlanChanged
from server.domain.planning.plans import Plan, PlannedVisit
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository
from server.store.writing.campus_lock import CampusLock

_plan = tables.plans.c


class SqlPlanRepository(Repository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock | None) -> None:
        super().__init__(connection, campus_id, lock)
        self._all: dict[str, Plan] | None = None

    def get(self, vehicle_id: str) -> Plan | None:
        row = self._find(tables.plans, vehicle_id=vehicle_id)
        return None if row is None else plan_from_row(row)

    def all(self) -> tuple[Plan, ...]:
        """Read once a transaction: a concurrent change is detected when this one saves."""
        if self._all is None:
            self._all = {plan.vehicle_id: plan for plan in self._read_all()}
        return tuple(self._all[vehicle_id] for vehicle_id in sorted(self._all))

    def of(self, vehicle_ids: Set[str]) -> dict[str, Plan]:
        """By vehicle id."""
        rows = self._many(self._select(tables.plans, _plan.vehicle_id.in_(vehicle_ids)))
        return {row.vehicle_id: plan_from_row(row) for row in rows}

    def save(self, plan: Plan, expected_version: int) -> None:
        if not self._write(plan, expected_version):
            raise PlanChanged(f"the plan of {plan.vehicle_id} is no longer at version {expected_version}")
        if self._all is not None:
            self._all[plan.vehicle_id] = plan

    def _read_all(self) -> list[Plan]:
        rows = self._many(self._select(tables.plans).order_by(_plan.vehicle_id))
        return [plan_from_row(row) for row in rows]

    def _write(self, plan: Plan, expected_version: int) -> bool:
        values = {
            "vehicle_id": plan.vehicle_id,
            "version": plan.version,
            "visits": to_json(plan.visits),
            "resting_place_id": plan.resting_place_id or None,
        }
        if expected_version == 0:
            self._insert(tables.plans, values)
            return True
        return bool(self._change(tables.plans, values, vehicle_id=plan.vehicle_id, version=expected_version))


def plan_from_row(row: AnyRow) -> Plan:
    return Plan(
        campus_id=row.campus_id,
        vehicle_id=row.vehicle_id,
        version=row.version,
        visits=from_json(row.visits, tuple[PlannedVisit, ...]),
        resting_place_id=row.resting_place_id or "",
    )
