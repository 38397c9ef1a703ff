"""How the fleet is assigned between bookings. One dispatcher a campus holds a lease; others stand by.

A booking is decided in its own request (`usecases.rides.book`). This loop does what remains:
roads that close and open, rides that have lost their vehicle, routes and grants that were not safe yet,
expected times and promises, and moving waiting rides to where they cost less.
"""

from collections.abc import Awaitable, Callable
from dataclasses import replace
from functools import partial
from typing import TypeVar

from server.dispatch.solve import Budget
from server.domain.errors import LeaseLost
from server.supervision.standing_tasks import PeriodicTask
from server.supervision.steps import run_steps, run_together
from server.usecases.fleet import announcements, charging, closures, interventions
from server.usecases.orders import sections
from server.usecases.planning import earlier_promises, plans, promises, relocation
from server.usecases.planning.decisions import SearchSettings
from server.usecases.planning.snapshot import take_snapshot
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Ids
from server.usecases.ports.solver import Solver
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.rides import lost_vehicles

T = TypeVar("T")

LEASE = "dispatcher"
PERIOD_S = 1.0
LEASE_S = 10.0
# Expected times and improvement, every so many periods; idle vehicles move more rarely than rides.
SLOW_PERIODS = 5
RELOCATION_PERIODS = 15
# Searches in a row that changed nothing, after which one waits until a plan has changed: a third one for the
# same plans found something in 3 of 100 cases (20 shuttles, 120 rides an hour).
_FRUITLESS_MAX = 2
_EVERY_PERIOD: tuple[Callable[[UnitOfWork], object], ...] = (
    closures.update_closures,
    announcements.begin_due,
    lost_vehicles.rescue_riders,
    interventions.end_holds,
    plans.assign_waiting,
    sections.extend_grants,
    promises.check_promises,
)
_SLOW: tuple[Callable[[UnitOfWork], object], ...] = (
    closures.keep_reachable,
    charging.manage_charging,
    earlier_promises.promise_earlier,
)


class StandsBy(LeaseLost):
    """Another replica dispatches; this one waits."""


class Dispatcher:
    """slices: of one improvement, a count and not a time."""

    def __init__(
        self,
        transactions: Transactions,
        bus: Bus,
        solver: Solver,
        ids: Ids,
        campus_id: str,
        slices: int = 8,
    ) -> None:
        self._transactions = transactions
        self._solver = solver
        self._ids = ids
        self._budget = Budget(slices)
        self._holder = ids.new_id("dispatcher")
        self._token = 0
        self._periods = 0
        self._demand: relocation.Demand | None = None
        self._improvement: plans.Improvement | None = None
        self._searched: dict[str, int] = {}
        self._fruitless = 0
        heard = (topics.dispatch(campus_id),)
        self.task = PeriodicTask("dispatcher", self.run_once, PERIOD_S, bus, heard)

    async def run_once(self) -> None:
        """Keep the lease and do everything that is due. A step that fails stops no other one."""
        self._periods += 1
        is_slow = self._periods % SLOW_PERIODS == 0
        works = (*_EVERY_PERIOD, *_SLOW, self._refresh_expected) if is_slow else _EVERY_PERIOD
        steps: list[Callable[[], Awaitable[object]]] = [partial(run_together, self._leased, works)]
        if is_slow:
            steps.append(self._improve)
        if self._periods % RELOCATION_PERIODS == 0:
            steps.append(self._relocate)
        try:
            await run_steps(steps)
        except StandsBy:
            return

    async def _improve(self) -> None:
        """Solve outside of transactions; an answer that comes too late is dropped."""
        improvement, self._improvement = self._improvement, None
        if improvement is None or self._budget.slices == 0:
            return
        seed = self._ids.seed()
        solution = await self._solver.solve(improvement.problem, self._budget, seed)
        if not improvement.is_changed_by(solution):
            self._fruitless += 1
            return
        self._fruitless = 0
        search = SearchSettings(replace(self._budget, stop_after=solution.slices), seed)
        await self._fenced(lambda uow: plans.adopt_improvement(uow, improvement, solution, search))

    def _refresh_expected(self, uow: UnitOfWork) -> None:
        """Update expected times, and note what could be improved: both need the fleet as it is."""
        snapshot = take_snapshot(uow)
        versions = {vehicle_id: plan.version for vehicle_id, plan in snapshot.plans.items()}
        if versions != self._searched:
            self._searched, self._fruitless = versions, 0
        is_worth = self._fruitless < _FRUITLESS_MAX
        self._improvement = plans.improvement_of(snapshot) if is_worth else None
        plans.refresh_expected(uow, snapshot)

    async def _relocate(self) -> None:
        """Move one idle vehicle. Expected pickups are learned every hour, by reads."""
        demand = self._demand

        def choose(uow: UnitOfWork) -> tuple[bool, relocation.Relocation | None]:
            if demand is None or relocation.is_stale(uow, demand):
                return True, None
            return False, relocation.best_relocation(uow, demand)

        is_stale, move = await self._transactions.read(choose)
        if is_stale:
            learned = self._demand = await self._transactions.read(relocation.learn_demand)
            move = await self._transactions.read(lambda uow: relocation.best_relocation(uow, learned))
        if move is not None:
            await self._fenced(lambda uow: relocation.relocate(uow, move))

    async def _leased(self, work: Callable[[UnitOfWork], T]) -> T:
        """In one transaction with the lease. Raises StandsBy while another dispatcher holds it."""

        def with_lease(uow: UnitOfWork) -> T:
            token = uow.leases.take(LEASE, self._holder, uow.now, LEASE_S)
            if token is None:
                raise StandsBy("another dispatcher holds the lease")
            self._token = token
            return work(uow)

        return await self._transactions.run(with_lease)

    async def _fenced(self, work: Callable[[UnitOfWork], T]) -> T:
        def under_lease(uow: UnitOfWork) -> T:
            if uow.leases.token(LEASE) != self._token:
                raise LeaseLost("another dispatcher has taken over")
            return work(uow)

        return await self._transactions.run(under_lease)
