"""The linear relaxation over routes: column generation, subset-row cuts, and solutions from the columns."""

from collections.abc import Generator, Sequence

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
from campusloop.studies.bound.pricing import Prices, PricingResult, Reach, price, reach_of
from campusloop.studies.bound.progress import Limits, Progress
from campusloop.studies.bound.proof_state import ProofState
from campusloop.studies.bound.routes import Routes, bits_of, routes_of, sets_as_matrix
from server.dispatch.arrays import AnyArray

_NEGATIVE = -1e-7
_CONVERGED = 1e-5  # between the relaxation's value and its proven bound
_WHOLE = 1e-6
_CUTS_PER_REQUEST, _VIOLATION = 4, 0.02


class Relaxation:
    """What it finds goes into the proof's state: duals and their bound, columns, cuts, and solutions.

    cost_max  no choice of routes costs more
    """

    def __init__(self, network: Network, limits: Limits, state: ProofState) -> None:
        self._network, self._limits, self._state = network, limits, state
        self._graph: EventGraph = event_graph(network, limits.events_max)
        self._reach: Reach = reach_of(network)
        n = network.requests
        up, down = np.arange(1, n + 1), np.arange(n + 1, 2 * n + 1)
        travel = network.travel
        alone = travel[0, up] + travel[up, down] + travel[down, 0]
        # Each leg of each vehicle once.
        self.cost_max = float((2 * n + network.vehicles) * travel.max()) + 1.0
        # At least 1, for all the places may be one and the same.
        self._unserved_cost = min(max(1.0, 3.0 * float(alone.max())), self.cost_max)
        self.master = Master(n, network.vehicles, self._unserved_cost)
        self.master.add_routes(routes_of(network, 2 * np.arange(n + 1), np.stack([up, down], axis=1).ravel()))
        self._known: set[tuple[int, int, int]] = set()

    def begin_with(self, plan: Sequence[Sequence[int]]) -> None:
        """Columns of a plan, before any are priced."""
        if not plan:
            return
        place = {int(node): k for k, node in enumerate(self._network.nodes)}
        starts = np.cumsum([0, *map(len, plan)])
        nodes = np.array([place[node] for route in plan for node in route], np.int64)
        self.master.add_routes(routes_of(self._network, starts, nodes))

    def solve(self, stage: str) -> Generator[Progress, None, RelaxationResult | None]:
        """Column generation until the relaxation is solved; its last answer, or None when the labels ran out.

        Prices are taken half way between the best duals so far and the present ones (Wentges 1997); where
        that finds nothing new, the present ones decide.
        """
        state = self._state
        smoothing = 0.5
        while True:
            relaxed = self.master.solve()
            self._keep_if_whole(relaxed)
            priced = self._price(state.duals.towards(relaxed.duals, 1.0 - smoothing))
            state.rounds += 1
            if priced is None:
                return None
            added = self.master.add_routes(routes_of(self._network, priced.starts, priced.nodes))
            state.columns += added
            yield state.progress(stage)
            if relaxed.value - state.relaxed_bound < _CONVERGED or (added == 0 and smoothing == 0.0):
                if relaxed.unserved <= _WHOLE or self._unserved_cost >= self.cost_max:
                    return relaxed
                self._unserved_cost = min(10.0 * self._unserved_cost, self.cost_max)
                self.master.raise_unserved_cost(self._unserved_cost)
            smoothing = 0.5 if added else 0.0
            if len(self.master.routes) > self._limits.columns_max:
                self.master.keep_cheapest(relaxed.duals, self._limits.columns_max // 2)

    def add_cuts(self, relaxed: RelaxationResult) -> bool:
        """Add violated subset-row cuts. Returns whether there were any."""
        used = np.flatnonzero(relaxed.flow > _WHOLE)
        sets = sets_as_matrix(self.master.routes.served[used], self._network.requests)
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
        self.master.add_cuts(cuts)
        self._state.cuts = len(self.master.cuts)
        return True

    def search_solution(self, relaxed: RelaxationResult | None) -> None:
        """Look for a solution among the columns."""
        state = self._state
        duals = state.duals if relaxed is None else relaxed.duals
        routes = self.master.routes
        reduced = self.master.reduced_costs(routes, duals)
        promising = routes.chosen(np.argsort(reduced, kind="stable")[: self._limits.search_routes])
        used = integer_solution(
            promising,
            self._network.requests,
            self._network.vehicles,
            state.cutoff,
            self._limits.search_nodes,
        )
        if used is not None:
            state.best = promising.chosen(used)

    def routes_below(self, duals: Duals, reduced_max: float, labels_max: int) -> Routes | None:
        """All routes with a reduced cost below reduced_max, or None when they are too many."""
        priced = price(
            self._network,
            self._graph,
            self._reach,
            self._prices(duals),
            reduced_max,
            relaxed_share=0.0,
            every_set=True,
            labels_max=labels_max,
            routes_max=self._limits.pool_max + 1,
        )
        if not priced.complete or len(priced.reduced) > self._limits.pool_max:
            self._state.limit = f"the routes within the gap need more than {labels_max} labels"
            if priced.complete:
                self._state.limit = f"there are more than {self._limits.pool_max} routes within the gap"
            return None
        self._state.limit = ""
        return routes_of(self._network, priced.starts, priced.nodes)

    def _price(self, duals: Duals) -> PricingResult | None:
        """Routes at these duals, and the bound that they prove. None when not even one was found within the
        labels.
        """
        state = self._state
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
            state.limit = f"pricing needs more than {self._limits.labels_max} labels"
            return priced if len(priced.reduced) else None
        least = min(priced.threshold, float(priced.reduced.min(initial=0.0)))
        bound = lagrangian_bound(duals, self._network.vehicles, least)
        if bound > state.relaxed_bound:
            state.duals, state.relaxed_bound = duals, bound
            state.bound = max(bound, state.bound)
        return priced

    def _prices(self, duals: Duals) -> Prices:
        """Duals as the kernels want them; cuts without a price left out."""
        n = self._network.requests
        priced = np.flatnonzero(duals.penalty > 0.0)
        cuts = self.master.cuts[priced]
        reward = np.zeros(2 * n + 1)
        reward[1 : n + 1] = duals.reward
        cuts_of = np.zeros((n, (len(cuts) + 63) // 64), np.uint64)
        for k, cut in enumerate(cuts):
            cuts_of[cut, k >> 6] |= np.uint64(1) << np.uint64(k & 63)
        return Prices(reward, duals.fixed, duals.penalty[priced], bits_of(cuts, n), cuts_of)

    def _keep_if_whole(self, relaxed: RelaxationResult) -> None:
        """Keep the relaxation's answer if it is a solution, better than the best one."""
        if relaxed.unserved > _WHOLE:
            return
        used = np.flatnonzero(relaxed.flow > 0.5)
        if np.abs(relaxed.flow - np.rint(relaxed.flow)).max() < _WHOLE:
            routes = self.master.routes.chosen(used)
            if float(routes.cost.sum()) < self._state.upper:
                self._state.best = routes
