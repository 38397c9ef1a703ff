"""The proof, step by step: column generation, cuts, enumeration of all routes within the gap, branch and
bound.

1. Column generation over elementary routes gives the root bound (relaxation.py, pricing.py, master.py).
2. Every solution that uses a route with reduced cost >= D costs at least bound + D. So all routes below the
   gap are enumerated, and the cheapest choice among them (tree.py) or bound + D, whichever is less, is proven
   (Baldacci, Christofides, Mingozzi 2008).
3. Where they are too many, subset-row cuts first narrow the gap.

The bound never depends on how exact the linear solver is: it is a Lagrangian bound, computed anew from
duals that are merely cut off at zero (master.lagrangian_bound).
"""

from collections.abc import Generator, Iterator, Sequence

import numpy as np

from campusloop.studies.bound.master import Duals, RelaxationResult
from campusloop.studies.bound.network import Network
from campusloop.studies.bound.progress import Limits, Progress
from campusloop.studies.bound.proof_state import ProofState
from campusloop.studies.bound.relaxation import Relaxation
from campusloop.studies.bound.routes import Routes
from campusloop.studies.bound.tree import PRUNE_WITHIN, Tree
from campusloop.studies.instances.instance import InstanceBroken

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
    state = ProofState(network, upper, Duals(np.zeros(network.requests), 0.0, np.empty(0)))
    relaxation = Relaxation(network, limits, state)
    relaxation.begin_with(plan)
    yield state.progress("graph")
    for progress in _Proof(limits, state, relaxation).run():
        if progress.bound > relaxation.cost_max:
            raise InstanceBroken(f"{network.vehicles} vehicles cannot serve all requests")
        yield progress


class _Proof:
    def __init__(self, limits: Limits, state: ProofState, relaxation: Relaxation) -> None:
        self._limits, self._state, self._relaxation = limits, state, relaxation

    def run(self) -> Iterator[Progress]:
        """All stages, until the gap is closed or nothing more can be done within the limits."""
        state, labels_max = self._state, self._limits.enumeration_labels_max
        relaxed = yield from self._relaxation.solve("root")
        root = state.duals, state.relaxed_bound
        yield from self._enumerate_from(*root, labels_max // 32)
        for patience, shares in ((_PATIENCE, (16, 4)), (_LAST_PATIENCE, (4, 2, 1))):
            relaxed = yield from self._tighten(relaxed, patience)
            for share in shares:
                yield from self._enumerate_from(*root, labels_max // share)
                yield from self._enumerate_from(state.duals, state.relaxed_bound, labels_max // share)
        yield state.progress("done")

    def _enumerate_from(self, duals: Duals, proven: float, labels_max: int) -> Iterator[Progress]:
        """More and more of the gap, as far as the labels allow, at duals that prove a bound.

        The root's see a wider gap, but without cuts endings are bounded better; which lets more be seen,
        differs.
        """
        state = self._state
        margin = _FIRST_MARGIN * proven
        while state.gap > _OPEN and proven > 0.0:
            ceiling = min(state.bound + margin, state.cutoff)
            pool = self._relaxation.routes_below(duals, ceiling - proven + PRUNE_WITHIN, labels_max)
            yield state.progress("enumerate")
            if pool is None:
                return
            yield from self._branch(pool, ceiling)
            margin *= 2.0

    def _tighten(
        self, relaxed: RelaxationResult | None, patience: int
    ) -> Generator[Progress, None, RelaxationResult | None]:
        """Subset-row cuts, until so many rounds of them were not worth much; a plan from the columns."""
        state, slow = self._state, 0
        while state.gap > _OPEN and relaxed is not None and slow < patience:
            before = state.relaxed_bound
            if len(self._relaxation.master.cuts) >= self._limits.cuts_max:
                state.limit = f"{self._limits.cuts_max} cuts leave a gap"
                break
            if not self._relaxation.add_cuts(relaxed):
                break
            relaxed = yield from self._relaxation.solve("cuts")
            slow = slow + 1 if state.relaxed_bound - before < _SLOW * state.bound else 0
        if state.gap > _WIDE * state.bound:
            self._relaxation.search_solution(relaxed)
            yield state.progress("search")
        return relaxed

    def _branch(self, pool: Routes, ceiling: float) -> Iterator[Progress]:
        """The cheapest choice from the pool, or the proof that it costs no less than the ceiling."""
        state = self._state
        reduced = self._relaxation.master.reduced_costs(pool, state.duals)
        pool = pool.chosen(np.flatnonzero(state.relaxed_bound + reduced < min(ceiling, state.cutoff)))
        # Only cuts that have a price: rows that do not bind are found again where they do.
        penalty = state.duals.penalty
        priced = np.flatnonzero(penalty > 0.0)
        tree = Tree(
            pool,
            state.network.requests,
            state.network.vehicles,
            self._relaxation.master.cuts[priced],
            Duals(state.duals.reward, state.duals.fixed, penalty[priced]),
            min(ceiling, state.given),
            state.cutoff,
        )
        nodes = state.nodes
        for step in tree.steps():
            if step.best is not None:
                state.best = step.best
            state.bound = max(state.bound, step.bound)
            state.nodes = nodes + step.nodes
            yield state.progress("branch")
