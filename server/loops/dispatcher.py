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
from server.usecases.fleet import charging, closures, interventions
from server.usecases.orders import sections
from server.usecases.planning import plans, promises, relocation
from server.usecases.planning.decisions import SearchSettings
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
# Expected times and improvement, every so many periods.
SLOW_PERIODS = 5
_EVERY_PERIOD: tuple[Callable[[UnitOfWork], object], ...] = (
    closures.update_closures,
    lost_vehicles.rescue_riders,
    interventions.end_holds,
    plans.assign_waiting,
    sections.extend_grants,
    promises.check_promises,
)
_SLOW: tuple[Callable[[UnitOfWork], object], ...] = (
    closures.keep_reachable,
    charging.manage_charging,
    plans.refresh_expected,
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
        heard = (topics.dispatch(campus_id),)
        self.task = PeriodicTask("dispatcher", self.run_once, PERIOD_S, bus, heard)

    async def run_once(self) -> None:
        """Keep the lease and do everything that is due. A step that fails stops no other one."""
        self._periods += 1
        is_slow = self._periods % SLOW_PERIODS == 0
        works = (*_EVERY_PERIOD, *_SLOW) if is_slow else _EVERY_PERIOD
        steps: list[Callable[[], Awaitable[object]]] = [partial(run_together, self._leased, works)]
        if is_slow:
            steps += [self._improve, self._relocate]
        try:
            await run_steps(steps)
        except StandsBy:
            return

    async def _improve(self) -> None:
        """Solve outside of transactions; an answer that comes too late is dropped."""
        # In the writer's transactions, whose memory has the fleet: a reader would decode all its rows.
        improvement = await self._fenced(plans.improvement_of)
        if improvement is None or self._budget.slices == 0:
            return
        seed = self._ids.seed()
        solution = await self._solver.solve(improvement.problem, self._budget, seed)
        if not improvement.is_changed_by(solution):
            return
        search = SearchSettings(replace(self._budget, stop_after=solution.slices), seed)
        await self._fenced(lambda uow: plans.adopt_improvement(uow, improvement, solution, search))

    async def _relocate(self) -> None:
        """Move one idle vehicle. Expected pickups are learned every hour, by reads."""
        if await self._transactions.read(lambda uow: relocation.is_stale(uow, self._demand)):
            self._demand = await self._transactions.read(relocation.learn_demand)
        demand = self._demand
        if demand is None:
            return
        move = await self._transactions.read(lambda uow: relocation.best_relocation(uow, demand))
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
