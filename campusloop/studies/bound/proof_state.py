"""What a proof knows at a moment: the bound, the best solution, and how much work that took."""

from dataclasses import dataclass

import numpy as np

from campusloop.studies.bound.master import Duals
from campusloop.studies.bound.network import Network
from campusloop.studies.bound.progress import Progress
from campusloop.studies.bound.routes import Routes, each_request_once


@dataclass(slots=True)
class ProofState:
    """Changed by the relaxation and by branch and bound.

    given          cost of a solution known from elsewhere, inf for none
    duals          the best of the relaxation so far
    relaxed_bound  what these duals prove; enumeration may know better, and then `bound` is higher
    best           the best solution that the proof has found
    limit          which of its limits the proof has met last, "" for none
    """

    network: Network
    given: float
    duals: Duals
    relaxed_bound: float = 0.0
    bound: float = 0.0
    best: Routes | None = None
    columns: int = 0
    rounds: int = 0
    cuts: int = 0
    nodes: int = 0
    limit: str = ""

    @property
    def upper(self) -> float:
        """The cost of the best solution found."""
        return float(self.best.cost.sum()) if self.best is not None else np.inf

    @property
    def cutoff(self) -> float:
        """The cost of the best solution known."""
        return min(self.upper, self.given)

    @property
    def gap(self) -> float:
        return self.cutoff - self.bound

    def progress(self, stage: str) -> Progress:
        """A snapshot."""
        routes = [] if self.best is None else [self.best.visits(k) for k in range(len(self.best))]
        solution = each_request_once(routes, self.network.requests)
        return Progress(
            stage=stage,
            bound=self.bound,
            upper=self.upper,
            columns=self.columns,
            rounds=self.rounds,
            cuts=self.cuts,
            nodes=self.nodes,
            solution=tuple(tuple(int(self.network.nodes[v]) for v in route) for route in solution),
            limit=self.limit,
        )
