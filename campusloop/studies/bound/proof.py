"""The proof, step by step: column generation, cuts, enumeration of all routes within the gap, branch and
bound.

1. Column generation over elementary routes gives the root bound (pricing.py, master.py).
2. Every solution that uses a route with reduced cost >= D costs at least bound + D. So all routes below D =
gap are
   enumerated, and the cheapest choice among them (tree.py) or bound + D, whichever is less, is proven
   (Baldacci, Christofides, Mingozzi 2008).
3. Where they are too many, subset-row cuts first narrow the gap.

The bound never depends on how exact the linear solver is: it is a Lagrangian bound, computed anew from
duals that are merely cut off at zero (master.lagrangian_bound).
"""

from collections.abc import Generator, Iterator, Sequence

import numpy as np

from campusloop.studies.bound.cuts import violated_cuts
from campusloop.studies.bound.events import EventGraph, event_graph
from campusloop.studies.bound.master import (
    Duals,
    Master,
    RelaxationResult,
    integer_solution,
    lagrangian_bound,
)
from campusloop.studies.bound.network import Network
from campusloop.studies.bound.pricing import (
    Prices,
    PricingResult,
    Reach,
    price,
    reach_of,
)
from campusloop.studies.bound.progress import Limits, Progress
from campusloop.studies.bound.routes import (
    Routes,
    bits_of,
    each_request_once,
    routes_of,
    sets_as_matrix,
)
from campusloop.studies.bound.tree import PRUNE_WITHIN, Tree
from campusloop.studies.instances.instance import InstanceBroken
from server.dispatch.arrays import AnyArray

_NEGATIVE = -1e-7
_CONVERGED = 1e-5  # between the relaxation's value and its proven bound
_WHOLE = 1e-6
_CUTS_PER_REQUEST, _VIOLATION = 4, 0.02
_FIRST_MARGIN = 1e-4  # by which an enumeration goes beyond the bound, in shares of it
_SLOW = 2e-5  # a round of cuts that raises the bound by a smaller share was not worth much
_PATIENCE, _LAST_PATIENCE = 3, 40  # such rounds before enumeration is tried, and when it has not been enough
_WIDE = 1e-3  # share of the bound; beyond such a gap it is worth looking for a better plan
_OPEN = 2.0 * PRUNE_WITHIN  # a smaller gap is none


def prove(
    network: Network, limits: Limits, upper: float = np.inf, plan: Sequence[Sequence[int]] = ()
) -> Iterator[Progress]:
    """Ever better bounds; every item is one slice of work. Raises TooManyEvents, and
    InstanceBroken once it is proven that the vehicles are too few.

    upper  the cost of a solution known from elsewhere: it spares work, and no more is proven than that
    plan   routes of a solution as node indices of the instance: prices near the truth to begin with
    """
    proof = _Proof(network, limits, upper)
    proof.begin_with(plan)
    yield proof.progress("graph")
    for progress in proof.run():
        if progress.bound > proof.cost_max:
            raise InstanceBroken(f"{network.vehicles} vehicles cannot serve all requests")
        yield progress


class _Proof:
    def __init__(self, network: Network, limits: Limits, upper: float) -> None:
        self._network, self._limits = network, limits
        self._graph: EventGraph = event_graph(network, limits.events_max)
        self._reach: Reach = reach_of(network)
        n = network.requests
        up, down = np.arange(1, n + 1), np.arange(n + 1, 2 * n + 1)
        travel = network.travel
        alone = travel[0, up] + travel[up, down] + travel[down, 0]
        # No choice of routes is longer: each leg of each vehicle once.
        self.cost_max = float((2 * n + network.vehicles) * travel.max()) + 1.0
        # At least 1, for all the places may be one and the same.
        self._unserved_cost = min(max(1.0, 3.0 * float(alone.max())), self.cost_max)
        self._master = Master(n, network.vehicles, self._unserved_cost)
        self._master.add_routes(
            routes_of(network, 2 * np.arange(n + 1), np.stack([up, down], axis=1).ravel())
        )
        self._given = upper
        self._best: Routes | None = None
        self._bound = 0.0
        # What the best duals of the relaxation prove; enumeration may know better.
        self._relaxed_bound = 0.0
        self._duals = Duals(np.zeros(n), 0.0, np.empty(0))
        self._rounds = self._nodes = self._columns = 0
        self._known: set[tuple[int, int, int]] = set()
        self._limit = ""

    def begin_with(self, plan: Sequence[Sequence[int]]) -> None:
        """Columns of a plan, before any are priced."""
        if not plan:
            return
        place = {int(node): k for k, node in enumerate(self._network.nodes)}
        starts = np.cumsum([0, *map(len, plan)])
        nodes = np.array([place[node] for route in plan for node in route], np.int64)
        self._master.add_routes(routes_of(self._network, starts, nodes))

    @property
    def _upper(self) -> float:
        return float(self._best.cost.sum()) if self._best is not None else np.inf

    @property
    def _cutoff(self) -> float:
        return min(self._upper, self._given)

    @property
    def _gap(self) -> float:
        return self._cutoff - self._bound

    def progress(self, stage: str) -> Progress:
        """A snapshot."""
        routes = [] if self._best is None else [self._best.visits(k) for k in range(len(self._best))]
        solution = each_request_once(routes, self._network.requests)
        return Progress(
            stage=stage,
            bound=self._bound,
            upper=self._upper,
            columns=self._columns,
            rounds=self._rounds,
            cuts=len(self._master.cuts),
            nodes=self._nodes,
            solution=tuple(tuple(int(self._network.nodes[v]) for v in route) for route in solution),
            limit=self._limit,
        )

    def run(self) -> Iterator[Progress]:
        """All stages, until the gap is closed or nothing more can be done within the limits."""
        labels_max = self._limits.enumeration_labels_max
        relaxed = yield from self._generate("root")
        root = self._duals, self._relaxed_bound
        yield from self._enumerate_from(*root, labels_max // 32)
        for patience, shares in ((_PATIENCE, (16, 4)), (_LAST_PATIENCE, (4, 2, 1))):
            relaxed = yield from self._tighten(relaxed, patience)
            for share in shares:
                yield from self._enumerate_from(*root, labels_max // share)
                yield from self._enumerate_from(self._duals, self._relaxed_bound, labels_max // share)
        yield self.progress("done")

    def _enumerate_from(self, duals: Duals, proven: float, labels_max: int) -> Iterator[Progress]:
        """More and more of the gap, as far as the labels allow, at duals that prove a bound.

        The root's see a wider gap, but without cuts endings are bounded better; which lets more be seen,
        differs.
        """
        margin = _FIRST_MARGIN * proven
        while self._gap > _OPEN and proven > 0.0:
            ceiling = min(self._bound + margin, self._cutoff)
            pool = self._enumerate(duals, ceiling - proven, labels_max)
            yield self.progress("enumerate")
            if pool is None:
                return
            yield from self._branch(pool, ceiling)
            margin *= 2.0

    def _tighten(
        self, relaxed: RelaxationResult | None, patience: int
    ) -> Generator[Progress, None, RelaxationResult | None]:
        """Subset-row cuts, until so many rounds of them were not worth much; a plan from the columns."""
        slow = 0
        while self._gap > _OPEN and relaxed is not None and slow < patience:
            before = self._relaxed_bound
            if len(self._master.cuts) >= self._limits.cuts_max:
                self._limit = f"{self._limits.cuts_max} cuts leave a gap"
                break
            if not self._cut(relaxed):
                break
            relaxed = yield from self._generate("cuts")
            slow = slow + 1 if self._relaxed_bound - before < _SLOW * self._bound else 0
        if self._gap > _WIDE * self._bound:
            self._search(relaxed)
            yield self.progress("search")
        return relaxed

    def _generate(self, stage: str) -> Generator[Progress, None, RelaxationResult | None]:
        """Column generation until the relaxation is solved; its last answer, or None when the labels ran out.

        Prices are taken half way between the best duals so far and the present ones (Wentges 1997); where
        that finds nothing new, the present ones decide.
        """
        smoothing = 0.5
        while True:
            relaxed = self._master.solve()
            self._keep_if_whole(relaxed)
            priced = self._price(self._duals.towards(relaxed.duals, 1.0 - smoothing))
            self._rounds += 1
            if priced is None:
                return None
            added = self._master.add_routes(routes_of(self._network, priced.starts, priced.nodes))
            self._columns += added
            yield self.progress(stage)
            if relaxed.value - self._relaxed_bound < _CONVERGED or (added == 0 and smoothing == 0.0):
                if relaxed.unserved <= _WHOLE or self._unserved_cost >= self.cost_max:
                    return relaxed
                self._unserved_cost = min(10.0 * self._unserved_cost, self.cost_max)
                self._master.raise_unserved_cost(self._unserved_cost)
            smoothing = 0.5 if added else 0.0
            if len(self._master.routes) > self._limits.columns_max:
                self._master.keep_cheapest(relaxed.duals, self._limits.columns_max // 2)

    def _price(self, duals: Duals) -> PricingResult | None:
        """Routes at these duals, and the bound that they prove. None when not even one was found within the
        labels.
        """
        for share in (0.5, 0.0, 0.9):
            priced = price(
                self._network,
                self._graph,
                self._reach,
                self._prices(duals),
                _NEGATIVE,
                relaxed_share=share,
                every_set=False,
                labels_max=self._limits.labels_max,
                routes_max=self._limits.columns_a_round,
            )
            if len(priced.reduced) or (priced.complete and share == 0.0):
                break
        if not priced.complete:
            self._limit = f"pricing needs more than {self._limits.labels_max} labels"
            return priced if len(priced.reduced) else None
        least = min(priced.threshold, float(priced.reduced.min(initial=0.0)))
        bound = lagrangian_bound(duals, self._network.vehicles, least)
        if bound > self._relaxed_bound:
            self._duals, self._relaxed_bound = duals, bound
            self._bound = max(bound, self._bound)
        return priced

    def _prices(self, duals: Duals) -> Prices:
        """Duals as the kernels want them; cuts without a price left out."""
        n = self._network.requests
        priced = np.flatnonzero(duals.penalty > 0.0)
        cuts = self._master.cuts[priced]
        reward = np.zeros(2 * n + 1)
        reward[1 : n + 1] = duals.reward
        cuts_of = np.zeros((n, (len(cuts) + 63) // 64), np.uint64)
        for k, cut in enumerate(cuts):
            cuts_of[cut, k >> 6] |= np.uint64(1) << np.uint64(k & 63)
        return Prices(reward, duals.fixed, duals.penalty[priced], bits_of(cuts, n), cuts_of)

    def _keep_if_whole(self, relaxed: RelaxationResult) -> None:
        """Is the relaxation's answer a solution?"""
        if relaxed.unserved > _WHOLE:
            return
        used = np.flatnonzero(relaxed.flow > 0.5)
        if np.abs(relaxed.flow - np.rint(relaxed.flow)).max() < _WHOLE:
            routes = self._master.routes.chosen(used)
            if float(routes.cost.sum()) < self._upper:
                self._best = routes

    def _search(self, relaxed: RelaxationResult | None) -> None:
        """Look for a solution among the columns."""
        duals = self._duals if relaxed is None else relaxed.duals
        routes = self._master.routes
        reduced = self._master.reduced_costs(routes, duals)
        promising = routes.chosen(np.argsort(reduced, kind="stable")[: self._limits.search_routes])
        used = integer_solution(
            promising,
            self._network.requests,
            self._network.vehicles,
            self._cutoff,
            self._limits.search_nodes,
        )
        if used is not None:
            self._best = promising.chosen(used)

    def _cut(self, relaxed: RelaxationResult) -> bool:
        """Add violated subset-row cuts, if any."""
        used = np.flatnonzero(relaxed.flow > _WHOLE)
        sets = sets_as_matrix(self._master.routes.served[used], self._network.requests)
        cuts: AnyArray = violated_cuts(
            sets,
            relaxed.flow[used],
            self._known,
            self._limits.cuts_a_round,
            _CUTS_PER_REQUEST,
            _VIOLATION,
        )
        if not len(cuts):
            return False
        self._known.update((int(i), int(j), int(k)) for i, j, k in cuts)
        self._master.add_cuts(cuts)
        return True

    def _enumerate(self, duals: Duals, width: float, labels_max: int) -> Routes | None:
        """All routes with a reduced cost below the width, or None when they are too many."""
        priced = price(
            self._network,
            self._graph,
            self._reach,
            self._prices(duals),
            width + PRUNE_WITHIN,
            relaxed_share=0.0,
            every_set=True,
            labels_max=labels_max,
            routes_max=self._limits.pool_max + 1,
        )
        if not priced.complete or len(priced.reduced) > self._limits.pool_max:
            self._limit = f"the routes within the gap need more than {labels_max} labels"
            if priced.complete:
                self._limit = f"there are more than {self._limits.pool_max} routes within the gap"
            return None
        self._limit = ""
        return routes_of(self._network, priced.starts, priced.nodes)

    def _branch(self, pool: Routes, ceiling: float) -> Iterator[Progress]:
        """The cheapest choice from the pool, or the proof that it costs no less than the ceiling."""
        reduced = self._master.reduced_costs(pool, self._duals)
        pool = pool.chosen(np.flatnonzero(self._relaxed_bound + reduced < min(ceiling, self._cutoff)))
        # Only cuts that have a price: rows that do not bind are found again where they do.
        penalty = self._duals.penalty
        priced = np.flatnonzero(penalty > 0.0)
        tree = Tree(
            pool,
            self._network.requests,
            self._network.vehicles,
            self._master.cuts[priced],
            Duals(self._duals.reward, self._duals.fixed, penalty[priced]),
            min(ceiling, self._given),
            self._cutoff,
        )
        nodes = self._nodes
        for state in tree.steps():
            if state.best is not None:
                self._best = state.best
            self._bound = max(self._bound, state.bound)
            self._nodes = nodes + state.nodes
            yield self.progress("branch")
