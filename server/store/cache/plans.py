"""Plans in memory. The only writer compares and sets without asking the database."""

from sqlalchemy import Connection

from server.domain.errors import PlanChanged
from server.domain.planning.plans import Plan
from server.store.cache.memory import RowCache, Rows
from server.store.planning.plans import SqlPlanRepository
from server.store.writing.campus_lock import CampusLock

_PLANS = "plans"


class CachedPlanRepository(SqlPlanRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def get(self, vehicle_id: str) -> Plan | None:
        return self._known().get(vehicle_id)

    def all(self) -> tuple[Plan, ...]:
        known = self._known()
        return tuple(known[vehicle_id] for vehicle_id in sorted(known))

    def save(self, plan: Plan, expected_version: int) -> None:
        present = self._known().get(plan.vehicle_id)
        if (0 if present is None else present.version) != expected_version:
            raise PlanChanged(f"the plan of {plan.vehicle_id} is no longer at version {expected_version}")
        place_id = plan.resting_place_id
        if place_id and any(
            other.resting_place_id == place_id and other.vehicle_id != plan.vehicle_id
            for other in self._known().values()
        ):
            raise PlanChanged(f"{place_id} is another vehicle's resting place")
        self._write(plan, expected_version)
        self._memory.put(_PLANS, plan.vehicle_id, plan)

    def _known(self) -> Rows:
        return self._memory.table(_PLANS, lambda: {plan.vehicle_id: plan for plan in self._read_all()})
