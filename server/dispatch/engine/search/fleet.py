"""As few vehicles as possible: a route is dropped, and its requests are inserted until all are served.

Absence counters say how often each request was left out, and an attempt is good if the requests that it
leaves out have low counters (Christiaens and Vanden Berghe 2020, section 5.5). Vehicles must all be the same.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.draw import bits, seeded, uniform
from server.dispatch.engine.nearness import near_requests
from server.dispatch.engine.plan import ABSENT, Plan, Scratch, copy_plan, empty_plan, refresh, scratch_for
from server.dispatch.engine.search.recreate import InsertionOffers, no_offers, put_back
from server.dispatch.engine.search.ruin import Undo, ruin_strings, undo_for
from server.dispatch.engine.search.search import begin_attempt, take_back
from server.dispatch.engine.task import Task, typical_drive_s

_NEIGHBOURS = 100
_ENDS = 2


@dataclass(frozen=True, slots=True)
class FleetSettings:
    """Counts and shares. attempts in a slice; heat: temperature as a share of a typical direct drive; the
    others as in `optimise.Settings`."""

    attempts: int = 1000
    heat: float = 0.05
    mean_out: float = 12.0
    longest: float = 10.0
    blink: float = 0.01
    regretful: float = 0.1


class RouteElimination(NamedTuple):
    """How one call of `squeeze` goes: `FleetSettings` with the temperature in cost."""

    attempts: int
    heat: float
    mean_out: float
    longest: float
    blink: float
    regretful: float


class FleetSearch:
    """Fewer and fewer vehicles. The same task, seed and number of slices give the same plan.

    task, best   the smallest task so far whose plan serves all requests, and that plan; the task itself and
                 the requests that could be served while there is none
    """

    def __init__(self, task: Task, seed: int, settings: FleetSettings | None = None) -> None:
        how = settings or FleetSettings()
        room = 2 * task.requests + _ENDS
        self.task = self._task = self._whole = task
        self._settings = how
        self.slices = 0
        self._room, self._rng = room, seeded(seed)
        self._how = RouteElimination(
            how.attempts,
            how.heat * typical_drive_s(task),
            how.mean_out,
            how.longest,
            how.blink,
            how.regretful,
        )
        self._scratch = scratch_for(task, room)
        self._undo = undo_for(empty_plan(task, room))
        self._offers = no_offers(task)
        self._near = near_requests(task, _NEIGHBOURS)
        self._missed = np.zeros(task.requests)
        self.best, self._plan = plan_of(task, [], room), plan_of(task, [], room)

    def run_slice(self) -> None:
        """So many attempts; each time that all requests are served, the next route is dropped."""
        left = self._how.attempts
        while left > 0 and self._task.vehicles > 0:
            left -= squeeze(
                self._task,
                self._plan,
                self._scratch,
                self._undo,
                self._offers,
                self._near,
                self._missed,
                self._rng,
                self._how._replace(attempts=left),
            )
            if (self._plan.vehicle_of == ABSENT).any():
                if (self.best.vehicle_of == ABSENT).any():
                    copy_plan(self.best, self._plan)
                break
            self._drop_a_route()
        self.slices += 1

    def another(self, slices: int = 10) -> Plan:
        """Another plan with as few vehicles, from nothing; `best` if so many slices find none."""
        search = FleetSearch(self._whole, int(bits(self._rng) >> np.uint64(1)), self._settings)
        while search.task.vehicles > self.task.vehicles and search.slices < slices:
            search.run_slice()
        if search.task.vehicles > self.task.vehicles or (search.best.vehicle_of == ABSENT).any():
            return self.best
        return plan_of(self.task, routes_of(search.best), self._room)

    def _drop_a_route(self) -> None:
        """Keep the plan, and begin another one without the route whose requests have the lowest counters."""
        routes = [route for route in routes_of(self._plan) if len(route)]
        self.task = with_vehicles(self.task, len(routes))
        self.best = plan_of(self.task, routes, self._room)
        sums = [self._missed[route[route & 1 == 0] >> 1].sum() for route in routes]
        del routes[int(np.argmin(sums))]
        self._task = with_vehicles(self.task, len(routes))
        self._plan = plan_of(self._task, routes, self._room)


def with_vehicles(task: Task, vehicles: int) -> Task:
    """The same task with only its first vehicles, which must all be the same. No timed calls."""
    nodes = 2 * (task.requests + vehicles)
    return task._replace(
        place=task.place[:nodes],
        early_s=task.early_s[:nodes],
        late_s=task.late_s[:nodes],
        service_s=task.service_s[:nodes],
        load=task.load[:nodes],
        ride_s_max=task.ride_s_max[:nodes],
        delay_cost=task.delay_cost[:nodes],
        capacity=task.capacity[:vehicles],
        kind=task.kind[:vehicles],
        drive_s_max=task.drive_s_max[:vehicles],
        vehicle_cost=task.vehicle_cost[:vehicles],
    )


def routes_of(plan: Plan) -> list[AnyArray]:
    """For each vehicle its nodes in order, start and end left out."""
    return [route[1 : n - 1].copy() for route, n in zip(plan.route, plan.length, strict=True)]


def plan_of(task: Task, routes: list[AnyArray], room: int) -> Plan:
    """A plan of the task in which the first vehicles drive these routes."""
    plan, scratch = empty_plan(task, room), scratch_for(task, room)
    for v in range(task.vehicles):
        nodes = routes[v] if v < len(routes) else np.zeros(0, np.int32)
        n = len(nodes) + _ENDS
        plan.route[v, n - 1] = plan.route[v, 1]
        plan.route[v, 1 : n - 1], plan.length[v] = nodes, n
        plan.vehicle_of[nodes >> 1] = v
        refresh(task, plan, scratch, v)
    return plan


@kernel
def squeeze(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    undo: Undo,
    offers: InsertionOffers,
    near: AnyArray,
    missed: AnyArray,
    rng: AnyArray,
    how: RouteElimination,
) -> int:
    """Attempts until all requests are served. Returns how many there were.

    missed   (R,) how often each request was left out
    """
    for attempt in range(how.attempts):
        begin_attempt(task, plan, undo)
        ruin_strings(task, plan, scratch, undo, near, how.mean_out, how.longest, rng)
        put_back(task, plan, scratch, undo, offers, how.blink, how.regretful, rng)
        fewer, rarer, changed = 0, 0.0, 0.0
        for k in range(undo.counts[1]):
            r = undo.absent[k]
            if undo.home[k] == ABSENT:
                fewer -= 1
                rarer -= missed[r]
            if plan.vehicle_of[r] == ABSENT:
                fewer += 1
                rarer += missed[r]
        for k in range(undo.counts[0]):
            v = undo.touched_list[k]
            changed += plan.cost[v] - undo.before.cost[v]
        left_out = False
        for k in range(undo.counts[1]):
            r = undo.absent[k]
            if plan.vehicle_of[r] == ABSENT:
                missed[r] += 1.0
                left_out = True
        if not left_out:
            return attempt + 1
        limit = -how.heat * np.log(1.0 - uniform(rng))
        if fewer >= 0 and rarer >= 0.0 and not (fewer == 0 and rarer == 0.0 and changed < limit):
            take_back(plan, undo)
    return how.attempts
