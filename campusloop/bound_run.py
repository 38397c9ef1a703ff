"""Run a proof of a lower bound until it is closed or time is up. The proof counts; this file owns the
clock.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from server.dispatch.bound.network import network_of
from server.dispatch.bound.progress import CLOSED_WITHIN, Limits, Progress
from server.dispatch.bound.proof import prove
from server.dispatch.engine.from_instance import node_routes, task_of, unserved
from server.dispatch.engine.optimise import Optimiser
from server.dispatch.instance import Instance

Routes = tuple[tuple[int, ...], ...]

# The engine's share of the time, and its most: a good solution spares the proof more than that.
_SEARCH_SHARE, _SEARCH_S_MAX = 0.05, 30.0


@dataclass(frozen=True, slots=True)
class Solution:
    """cost in the instance's unit of distance, inf for none; routes as its nodes without the depot."""

    cost: float
    routes: Routes


@dataclass(frozen=True, slots=True)
class BoundRun:
    """What was proven, the best solution that engine and proof have found, and the time that it took.

    stopped   by the clock, before the proof had come to its end
    """

    proven: Progress
    best: Solution
    stopped: bool
    wall_s: float
    cpu_s: float

    @property
    def gap_pct(self) -> float | None:
        """Between the bound and the best solution, None without one."""
        if math.isinf(self.best.cost):
            return None
        if self.best.cost == 0.0:
            return 0.0
        return 100.0 * max(0.0, self.best.cost - self.proven.bound) / self.best.cost

    @property
    def closed(self) -> bool:
        """Is the best solution optimal, to the second decimal?"""
        return self.best.cost - self.proven.bound < CLOSED_WITHIN

    @property
    def limited_by(self) -> str:
        """Why there is still a gap, "" where there is none."""
        if self.closed:
            return ""
        reasons = [f"time, at the stage {self.proven.stage!r}"] if self.stopped else []
        return "; ".join([*reasons, self.proven.limit] if self.proven.limit else reasons)


def run_bound(
    instance: Instance,
    seconds: float,
    upper: float = math.inf,
    watch: Callable[[Progress], None] = lambda _: None,
) -> BoundRun:
    """Search a little, then prove, slice by slice, until the deadline; a slice that has begun is finished.

    upper   cost of a solution known from elsewhere: the bound is not pushed beyond it

    Raises InstanceBroken, TooManyEvents.
    """
    began_wall_s, began_cpu_s = time.monotonic(), time.process_time()
    network = network_of(instance)
    found = _searched(instance, began_wall_s + min(_SEARCH_SHARE * seconds, _SEARCH_S_MAX))
    place = {int(node): k for k, node in enumerate(instance.nodes)}
    plan = [[place[node] for node in route] for route in found.routes]
    steps = prove(network, Limits(), min(upper, found.cost), plan)
    stopped = False
    for proven in steps:
        watch(proven)
        if time.monotonic() - began_wall_s >= seconds:
            stopped = True
            break
    best = found
    if proven.upper < found.cost:
        routes = tuple(tuple(int(instance.nodes[k]) for k in route) for route in proven.solution)
        best = Solution(proven.upper, routes)
    return BoundRun(proven, best, stopped, time.monotonic() - began_wall_s, time.process_time() - began_cpu_s)


def _searched(instance: Instance, until_s: float) -> Solution:
    """The engine's best solution, or none where it serves not everybody in time."""
    optimiser = Optimiser(task_of(instance), seed=1)
    while time.monotonic() < until_s:
        optimiser.run_slice()
    if optimiser.slices == 0:
        return Solution(math.inf, ())
    optimiser.put_together()
    if len(unserved(optimiser.best)):
        return Solution(math.inf, ())
    routes = tuple(tuple(route) for route in node_routes(instance, optimiser.best) if route)
    return Solution(optimiser.cost, routes)
