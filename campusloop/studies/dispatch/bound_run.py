"""Runs the proof of a lower bound until it is closed or the time limit is reached. The proof itself has no
clock."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from campusloop.studies.bound.network import network_of
from campusloop.studies.bound.progress import CLOSED_WITHIN, Limits, Progress
from campusloop.studies.bound.proof import prove
from campusloop.studies.instances.instance import Instance
from campusloop.studies.instances.task import node_routes, task_of, unserved
from server.dispatch.engine.search.optimise import Optimiser

Routes = tuple[tuple[int, ...], ...]

# (seconds of search, share of the time limit after which an open proof is stopped). For most instances one
# second of search is enough. For the others a longer second search saves the proof more time than it costs.
_ROUNDS = ((1.0, 0.02), (30.0, 1.0))
# The search takes at most this share of the time limit.
_SEARCH_SHARE = 0.05


@dataclass(frozen=True, slots=True)
class Solution:
    """cost in the instance's unit of distance, inf for none; routes as its nodes without the depot."""

    cost: float
    routes: Routes


@dataclass(frozen=True, slots=True)
class BoundRun:
    """The proven bound, the best solution that engine and proof have found, and the time used.

    stopped   the time limit ended the proof
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
        """The best solution is optimal, to the second decimal."""
        return self.best.cost - self.proven.bound < CLOSED_WITHIN

    @property
    def limited_by(self) -> str:
        """Why there is still a gap; "" if there is none."""
        if self.closed:
            return ""
        reasons = [f"time, at the stage {self.proven.stage!r}"] if self.stopped else []
        if self.proven.limit:
            reasons.append(self.proven.limit)
        return "; ".join(reasons) or "the cost that was given: no more was to be proven"


def run_bound(
    instance: Instance,
    seconds: float,
    upper: float = math.inf,
    watch: Callable[[Progress], None] = lambda _: None,
) -> BoundRun:
    """Search for a short time, then prove in slices until the time limit; a started slice is finished.

    upper   cost of a known solution; the proof ends when the bound reaches it

    Raises InstanceBroken, TooManyEvents.
    """
    began_wall_s, began_cpu_s = time.monotonic(), time.process_time()
    network = network_of(instance)
    optimiser = Optimiser(task_of(instance), seed=1)
    best, bound, stopped = Solution(math.inf, ()), 0.0, False
    for search_s, share in _ROUNDS:
        best = _searched(instance, optimiser, min(search_s, _SEARCH_SHARE * seconds), best)
        stopped = False
        for step in prove(network, Limits(), min(upper, best.cost), _in_indices(instance, best.routes)):
            proven = replace(step, bound=max(step.bound, bound))
            watch(proven)
            if time.monotonic() - began_wall_s >= share * seconds:
                stopped = True
                break
        bound = proven.bound
        if proven.upper < best.cost:
            best = Solution(proven.upper, _in_numbers(instance, proven.solution))
        run = BoundRun(
            proven, best, stopped, time.monotonic() - began_wall_s, time.process_time() - began_cpu_s
        )
        if run.closed or run.wall_s >= seconds:
            break
    return run


def _searched(instance: Instance, optimiser: Optimiser, seconds: float, best: Solution) -> Solution:
    """The better of `best` and the best solution of the search that serves all requests."""
    began_s = time.monotonic()
    while time.monotonic() - began_s < seconds:
        optimiser.run_slice()
    if optimiser.slices == 0:
        return best
    optimiser.put_together()
    if len(unserved(optimiser.best)) or optimiser.cost >= best.cost:
        return best
    routes = tuple(tuple(route) for route in node_routes(instance, optimiser.best) if route)
    return Solution(optimiser.cost, routes)


def _in_indices(instance: Instance, routes: Routes) -> Routes:
    """Routes as indices of the instance's rows, given as its node numbers."""
    index = {int(node): k for k, node in enumerate(instance.nodes)}
    return tuple(tuple(index[node] for node in route) for route in routes)


def _in_numbers(instance: Instance, routes: Routes) -> Routes:
    return tuple(tuple(int(instance.nodes[k]) for k in route) for route in routes)
