"""The whole search, slice by slice: anneal, remember routes, choose the best mix of them, begin again.

A slice is a count of attempts, so that a search can be repeated. The caller owns time: it runs slices until
its deadline and records how many there were.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from server.dispatch.engine.draw import seeded
from server.dispatch.engine.nearness import near_requests
from server.dispatch.engine.plan import Plan, copy_plan, empty_plan, refresh, scratch_for, total_cost
from server.dispatch.engine.search.partition import Partitioning, repartition
from server.dispatch.engine.search.pool import empty_pool
from server.dispatch.engine.search.recreate import no_offers
from server.dispatch.engine.search.ruin import undo_for
from server.dispatch.engine.search.search import Annealing, anneal
from server.dispatch.engine.task import Task, freedom, typical_drive_s

_NEIGHBOURS = 100
_ENDS = 2
# Freedom (see `freedom`) from which on windows count as wide.
_WIDE = 3.0
# With wide windows, the hottest temperature for each unit of freedom, and at most; the slices of a cycle
# for each request and unit of freedom squared, and at least.
_HOT, _HOT_MAX = 0.12, 0.7
_CYCLE, _CYCLE_LEAST = 0.055, 15


@dataclass(frozen=True, slots=True)
class Settings:
    """Counts and shares, no seconds.

    attempts     ruin and recreate attempts in a slice
    cycle        slices from hot to cold the first time
    growth       each further cycle has so many times as many, but no cycle more than `longest_cycle`
                 times the first
    afresh_every   every how many cycles one begins afresh, so that the pool gets routes of another kind; the
                 others begin with the best plan
    hot          temperature at the beginning as a share of a typical direct drive
    cold         temperature at the end as a share of that at the beginning
    mean_out     requests taken out in an attempt, on average; longest: visits in a string at most
    blink        chance to overlook a vehicle
    regretful    share of attempts that put requests back by regret
    promising    routes of attempts that cost at most so much more (share of a direct drive) are remembered
    columns, visits   room in the pool
    """

    attempts: int = 1000
    cycle: int = 15
    growth: float = 1.5
    longest_cycle: float = 5.4
    afresh_every: int = 2
    hot: float = 0.2
    cold: float = 0.05
    mean_out: float = 12.0
    longest: float = 10.0
    blink: float = 0.01
    regretful: float = 0.2
    promising: float = 0.4
    columns: int = 200_000
    visits: int = 5_000_000
    partitioning: Partitioning = field(default_factory=Partitioning)


def settings_for(task: Task) -> Settings:
    """What suits a task.

    With narrow windows, many short cycles, half of them from nothing, fill a pool whose routes combine well.
    With wide windows such cycles freeze at once and far too high, so cycles are hotter and longer. They end
    in local optima of very different cost, and heating does not lead out of them, so each one starts from
    nothing.
    """
    free = freedom(task)
    if free < _WIDE:
        return Settings()
    return Settings(
        cycle=max(_CYCLE_LEAST, round(_CYCLE * task.requests * free**2)),
        growth=1.0,
        afresh_every=1,
        hot=min(_HOT_MAX, _HOT * free),
    )


class Optimiser:
    """Improves a plan of a task. The same task, seed and number of slices give the same plan.

    start     where to begin; from no request served if not given
    afresh    makes another plan to begin from, each time another one; a plan without requests if not given
    best      the cheapest plan so far
    slices    how many have run
    bound_of_pool   least cost of any mix of the remembered routes: not a bound of the task
    """

    def __init__(
        self,
        task: Task,
        seed: int,
        settings: Settings | None = None,
        start: Plan | None = None,
        afresh: Callable[[], Plan] | None = None,
    ) -> None:
        self.task = task
        self.slices = 0
        self.bound_of_pool = -np.inf
        self._settings = settings or settings_for(task)
        room = 2 * task.requests + _ENDS if start is None else start.route.shape[1]
        self._scratch = scratch_for(task, room)
        before = self._without_requests(room)
        self.best, self._plan = (_copied(before if start is None else start) for _ in range(2))
        self._undo = undo_for(before)
        self._offers = no_offers(task)
        self._pool = empty_pool(task, self._settings.columns, self._settings.visits)
        self._near = near_requests(task, _NEIGHBOURS)
        self._rng = seeded(seed)
        self._unit = typical_drive_s(task)
        self._cycles, self._in_cycle, self._cycle = 0, 0, self._settings.cycle
        self._cycle_max = round(self._cycle * self._settings.longest_cycle)
        self._afresh = afresh or (lambda: self._without_requests(room))

    @property
    def cost(self) -> float:
        return float(total_cost(self.task, self.best))

    @property
    def at_rest(self) -> bool:
        """A cycle has just ended."""
        return self._in_cycle == 0

    def run_slice(self) -> None:
        """So many attempts; at the end of a cycle the best mix of the remembered routes is chosen."""
        how = self._settings
        began, ends = self._in_cycle / self._cycle, (self._in_cycle + 1) / self._cycle
        heat = how.hot * self._unit
        anneal(
            self.task,
            self._plan,
            self.best,
            self._scratch,
            self._undo,
            self._offers,
            self._pool,
            self._near,
            self._rng,
            Annealing(
                attempts=how.attempts,
                hot=heat * how.cold**began,
                cold=heat * how.cold**ends,
                mean_out=how.mean_out,
                longest=how.longest,
                blink=how.blink,
                regretful=how.regretful,
                promising=how.promising * self._unit,
            ),
        )
        self.slices += 1
        self._in_cycle += 1
        if self._in_cycle == self._cycle:
            self.put_together()
            self._cycles += 1
            again = self._cycles % how.afresh_every != 0
            copy_plan(self._plan, self.best if again else self._afresh())
            self._in_cycle, self._cycle = 0, min(self._cycle_max, round(self._cycle * how.growth))

    def put_together(self) -> bool:
        """Make the best plan from all remembered routes. Returns whether it became cheaper."""
        changed, master = repartition(
            self.task, self.best, self._pool, self._scratch, self._settings.partitioning
        )
        self.bound_of_pool = master.bound
        return changed

    def _without_requests(self, room: int) -> Plan:
        plan = empty_plan(self.task, room)
        for v in range(self.task.vehicles):
            refresh(self.task, plan, self._scratch, v)
        return plan


def _copied(plan: Plan) -> Plan:
    return Plan(*(part.copy() for part in plan))
