"""Branch and bound over enumerated routes: the cheapest choice among them, with a bound proven node by node.

With every route that matters at hand, pricing is looking them all through, and subset-row cuts cost nothing.
Branching is Ryan and Foster's (1981): two requests share a vehicle, or they do not.
"""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from campusloop.studies.bound.cuts import violated_cuts
from campusloop.studies.bound.master import (
    Duals,
    Master,
    RelaxationResult,
    integer_solution,
    lagrangian_bound,
)
from campusloop.studies.bound.routes import Routes, sets_as_matrix
from server.dispatch.arrays import AnyArray

PRUNE_WITHIN = 1e-6  # a node is done when it can be better by no more
_NEGATIVE = -1e-7
_WHOLE = 1e-6
_COLUMNS_A_ROUND = 200
_CUTS_A_ROUND = 60
_CUTS_PER_REQUEST = 6
_CUTS_MAX = 400
_CUT_ROUNDS_ROOT, _CUT_ROUNDS_NODE = 40, 2
_VIOLATION_ROOT, _VIOLATION_NODE = 0.02, 0.1
_HEURISTIC_ROUTES = 3000
_HEURISTIC_NODES = 200

Pair = tuple[int, int, bool]  # two requests; do they share a vehicle?


@dataclass(frozen=True, slots=True)
class TreeState:
    """bound of the cheapest choice, or what the cutoff was; best choice below the cutoff so far, or None."""

    bound: float
    best: Routes | None
    nodes: int
    columns: int
    cuts: int


class Tree:
    """The search below `cutoff`, which falls with every better solution.

    cuts, duals  of the master problem that the pool comes from: where the relaxation starts
    upper        cost of the best solution known; one below it is welcome even above the cutoff
    """

    def __init__(
        self,
        pool: Routes,
        requests: int,
        vehicles: int,
        cuts: AnyArray,
        duals: Duals,
        cutoff: float,
        upper: float,
    ) -> None:
        self._requests, self._vehicles = requests, vehicles
        self._cutoff, self._upper = min(cutoff, upper), upper
        self.best: Routes | None = None
        self._nodes = 0
        self._settled = np.inf  # the least bound of a node whose relaxation was a solution
        self._open: list[tuple[float, int, tuple[Pair, ...]]] = [(-np.inf, 0, ())]
        self._pool = pool
        self._master = Master(requests, vehicles, unserved_cost=2.0 * cutoff)
        self._master.add_cuts(cuts)
        cheapest = np.argsort(self._master.reduced_costs(pool, duals), kind="stable")
        self._master.add_routes(pool.chosen(cheapest[: 5 * requests]))
        self._known = {(int(i), int(j), int(k)) for i, j, k in cuts}

    def steps(self) -> Iterator[TreeState]:
        """One relaxation a step, until no node is left that could be better than the cutoff."""
        while self._open:
            parent_bound, _, pairs = heapq.heappop(self._open)
            if parent_bound >= self._cutoff - PRUNE_WITHIN:
                continue
            self._nodes += 1
            allowed = _keeping(self._pool.served, pairs)
            self._master.allow(_keeping(self._master.routes.served, pairs))
            bound, cut_rounds = parent_bound, 0
            while True:
                relaxed = self._master.solve()
                reduced = self._master.reduced_costs(self._pool, relaxed.duals)
                cheapest = float(reduced[allowed].min(initial=0.0))
                proven = lagrangian_bound(relaxed.duals, self._vehicles, cheapest)
                bound = max(bound, proven)
                yield self._state(bound)
                if bound >= self._cutoff - PRUNE_WITHIN:
                    break
                if cheapest < _NEGATIVE:
                    wanted = np.flatnonzero(allowed & (reduced < _NEGATIVE))
                    wanted = wanted[np.argsort(reduced[wanted], kind="stable")[:_COLUMNS_A_ROUND]]
                    if self._master.add_routes(self._pool.chosen(wanted)):
                        continue
                if not pairs:
                    allowed = self._fix(reduced, proven)
                if self._keep_if_whole(relaxed):
                    self._settled = min(self._settled, bound)
                    break
                rounds_max, least = (
                    (_CUT_ROUNDS_NODE, _VIOLATION_NODE) if pairs else (_CUT_ROUNDS_ROOT, _VIOLATION_ROOT)
                )
                if cut_rounds < rounds_max and self._cut(relaxed, least):
                    cut_rounds += 1
                    continue
                if not pairs:
                    self._look_for_better(self._master.reduced_costs(self._pool, relaxed.duals))
                self._branch(relaxed, bound, pairs)
                break
        yield self._state(self._cutoff)

    def _state(self, bound: float) -> TreeState:
        """The bound of the whole tree while one node stands at `bound`."""
        waiting = self._open[0][0] if self._open else np.inf
        proven = min(bound, waiting, self._settled, self._cutoff) - PRUNE_WITHIN
        return TreeState(proven, self.best, self._nodes, len(self._pool), len(self._master.cuts))

    def _fix(self, reduced: AnyArray, proven: float) -> AnyArray:
        """Forget routes that no solution below the cutoff uses: reduced costs and bound of the same duals."""
        kept = proven + reduced < self._cutoff
        if kept.mean() < 0.9:
            self._pool = self._pool.chosen(np.flatnonzero(kept))
        return np.ones(len(self._pool), np.bool_)

    def _keep_if_whole(self, relaxed: RelaxationResult) -> bool:
        """Is the relaxation's answer a solution? The node is then done."""
        if relaxed.unserved > _WHOLE or (np.abs(relaxed.flow - np.rint(relaxed.flow)) > _WHOLE).any():
            return False
        used = np.flatnonzero(relaxed.flow > 0.5)
        self._keep(self._master.routes.chosen(used))
        return True

    def _keep(self, routes: Routes) -> None:
        cost = float(routes.cost.sum())
        if cost < self._upper:
            self._upper, self.best = cost, routes
            self._cutoff = min(self._cutoff, cost)

    def _cut(self, relaxed: RelaxationResult, least: float) -> bool:
        """Add violated cuts, if any."""
        if len(self._master.cuts) >= _CUTS_MAX:
            return False
        used = np.flatnonzero(relaxed.flow > _WHOLE)
        sets = sets_as_matrix(self._master.routes.served[used], self._requests)
        cuts = violated_cuts(sets, relaxed.flow[used], self._known, _CUTS_A_ROUND, _CUTS_PER_REQUEST, least)
        if not len(cuts):
            return False
        self._known.update((int(i), int(j), int(k)) for i, j, k in cuts)
        self._master.add_cuts(cuts)
        return True

    def _look_for_better(self, reduced: AnyArray) -> None:
        """A bounded search for a solution among the most promising routes."""
        promising = np.argsort(reduced, kind="stable")[:_HEURISTIC_ROUTES]
        routes = self._pool.chosen(promising)
        used = integer_solution(routes, self._requests, self._vehicles, self._upper, _HEURISTIC_NODES)
        if used is not None:
            self._keep(routes.chosen(used))

    def _branch(self, relaxed: RelaxationResult, bound: float, pairs: tuple[Pair, ...]) -> None:
        """Two nodes, by the pair of requests whose sharing is least decided."""
        used = np.flatnonzero(relaxed.flow > _WHOLE)
        sets = sets_as_matrix(self._master.routes.served[used], self._requests).astype(np.float64)
        together = sets.T @ (sets * relaxed.flow[used, None])
        undecided = np.abs(together - 0.5)
        undecided[np.tril_indices(self._requests)] = np.inf
        for i, j, _ in pairs:
            undecided[i, j] = np.inf
        i, j = divmod(int(np.argmin(undecided)), self._requests)
        if not np.isfinite(undecided[i, j]):
            # Every pair is decided, yet some are served twice: the node's bound stays as it is.
            self._settled = min(self._settled, bound)
            return
        for k, share in enumerate((True, False)):
            heapq.heappush(self._open, (bound, 2 * self._nodes + k, (*pairs, (i, j, share))))


def _keeping(served: AnyArray, pairs: tuple[Pair, ...]) -> AnyArray:
    """(r,) which routes keep to all decisions."""
    keeps = np.ones(len(served), np.bool_)
    one = np.uint64(1)
    for i, j, share in pairs:
        with_i = (served[:, i >> 6] >> np.uint64(i & 63)) & one
        with_j = (served[:, j >> 6] >> np.uint64(j & 63)) & one
        keeps &= (with_i == with_j) if share else (with_i & with_j) == 0
    return keeps
