"""The master problem: choose at most m routes that together serve every request, at least cost.

A covering: serving a request twice is allowed, since leaving it out of one route is no dearer, and so the
duals are never negative. Subset-row cuts tighten its linear relaxation (cuts.py).
"""

from dataclasses import dataclass

import highspy
import numpy as np

from campusloop.studies.bound.routes import (
    Routes,
    bits_of,
    reduced_costs,
    routes_paying,
    sets_as_matrix,
)
from server.dispatch.arrays import AnyArray

_INF = highspy.kHighsInf
# A sum of a thousand doubles is off by less than this share of the sum of their sizes; subtracted from
# every bound, and so is a constant for the small ones.
_ROUNDING_SHARE = 1e-12
_ROUNDING = 1e-7


@dataclass(frozen=True, slots=True)
class Duals:
    """reward (n,), fixed, penalty (c,): all >= 0, so that they prove a bound whatever the solver's
    tolerances were.
    """

    reward: AnyArray
    fixed: float
    penalty: AnyArray

    def towards(self, other: "Duals", share: float) -> "Duals":
        """A point between; cuts that only the other knows count as 0 here."""
        penalty = np.zeros(len(other.penalty))
        penalty[: len(self.penalty)] = self.penalty
        return Duals(
            (1.0 - share) * self.reward + share * other.reward,
            (1.0 - share) * self.fixed + share * other.fixed,
            (1.0 - share) * penalty + share * other.penalty,
        )


@dataclass(frozen=True, slots=True)
class RelaxationResult:
    """value of the relaxation over the columns it has, its duals, flow (r,) of the routes, flow without a
    route.
    """

    value: float
    duals: Duals
    flow: AnyArray
    unserved: float


def lagrangian_bound(duals: Duals, vehicles: int, reduced_min: float) -> float:
    """No solution of at most `vehicles` routes costs less, if no route's reduced cost is less."""
    earned, paid = float(duals.reward.sum()), vehicles * duals.fixed + float(duals.penalty.sum())
    lost = vehicles * max(0.0, -reduced_min)
    return earned - paid - lost - _ROUNDING - _ROUNDING_SHARE * (earned + paid + lost)


class Master:
    """The relaxation over some routes, kept warm in HiGHS.

    Rows: n requests, the number of vehicles, then the cuts. Columns: n without a route at `penalty`, then
    the routes.
    """

    def __init__(self, requests: int, vehicles: int, unserved_cost: float) -> None:
        self._requests = requests
        self._lp = _quiet()
        nothing = np.empty(0, np.int32), np.empty(0)
        for _ in range(requests):
            self._lp.addRow(1.0, _INF, 0, *nothing)
        self._lp.addRow(-_INF, float(vehicles), 0, *nothing)
        for request in range(requests):
            self._lp.addCol(unserved_cost, 0.0, _INF, 1, np.array([request], np.int32), np.ones(1))
        words = (requests + 63) // 64
        self.routes = Routes(
            np.empty(0), np.empty((0, words), np.uint64), np.zeros(1, np.int64), np.empty(0, np.int32)
        )
        self.cuts = np.empty((0, 3), np.int64)
        self.members = np.empty((0, words), np.uint64)
        self._costs_by_set: dict[bytes, float] = {}

    def raise_unserved_cost(self, cost: float) -> None:
        """Make leaving a request out dearer."""
        for request in range(self._requests):
            self._lp.changeColCost(request, cost)

    def add_routes(self, routes: Routes) -> int:
        """Add those that serve a new set or an old one cheaper; how many."""
        new = []
        for k in range(len(routes)):
            key = routes.served[k].tobytes()
            if routes.cost[k] < self._costs_by_set.get(key, np.inf) - 1e-9:
                self._costs_by_set[key] = float(routes.cost[k])
                new.append(k)
        if not new:
            return 0
        added = routes.chosen(np.array(new))
        rows = np.concatenate(
            [
                sets_as_matrix(added.served, self._requests),
                np.ones((len(added), 1), np.uint8),
                routes_paying(added.served, self.members),
            ],
            axis=1,
        )
        of_route, row = np.nonzero(rows)
        starts = np.searchsorted(of_route, np.arange(len(added))).astype(np.int32)
        count = len(added)
        self._lp.addCols(
            count,
            added.cost,
            np.zeros(count),
            np.full(count, _INF),
            len(row),
            starts,
            row.astype(np.int32),
            np.ones(len(row)),
        )
        self.routes = self.routes.joined(added)
        return count

    def add_cuts(self, cuts: AnyArray) -> None:
        """(c, 3) requests of new subset-row cuts."""
        members = bits_of(cuts, self._requests)
        of_cut, route = np.nonzero(routes_paying(self.routes.served, members).T)
        starts = np.searchsorted(of_cut, np.arange(len(cuts))).astype(np.int32)
        count = len(cuts)
        self._lp.addRows(
            count,
            np.full(count, -_INF),
            np.ones(count),
            len(route),
            starts,
            (self._requests + route).astype(np.int32),
            np.ones(len(route)),
        )
        self.cuts = np.concatenate([self.cuts, cuts])
        self.members = np.concatenate([self.members, members])

    def keep_cheapest(self, duals: Duals, count: int) -> None:
        """Drop all but so many routes: those of the least reduced cost."""
        cheapest = np.argsort(self.reduced_costs(self.routes, duals), kind="stable")[:count]
        kept = np.zeros(len(self.routes), np.bool_)
        kept[cheapest] = True
        gone = np.flatnonzero(~kept)
        for k in gone:
            self._costs_by_set.pop(self.routes.served[k].tobytes(), None)
        self._lp.deleteCols(len(gone), (self._requests + gone).astype(np.int32))
        self.routes = self.routes.chosen(np.flatnonzero(kept))

    def allow(self, allowed: AnyArray) -> None:
        """Only routes of the mask (r,) may be used."""
        count = len(self.routes)
        self._lp.changeColsBounds(
            count,
            np.arange(self._requests, self._requests + count, dtype=np.int32),
            np.zeros(count),
            np.where(allowed, _INF, 0.0),
        )

    def solve(self) -> RelaxationResult:
        """The relaxation over the routes at hand."""
        self._lp.run()
        solution = self._lp.getSolution()
        dual = np.asarray(solution.row_dual)
        flow = np.asarray(solution.col_value)
        n = self._requests
        return RelaxationResult(
            value=float(self._lp.getInfo().objective_function_value),
            duals=Duals(
                np.maximum(dual[:n], 0.0), max(0.0, -float(dual[n])), np.maximum(-dual[n + 1 :], 0.0)
            ),
            flow=flow[n:],
            unserved=float(flow[:n].sum()),
        )

    def reduced_costs(self, routes: Routes, duals: Duals) -> AnyArray:
        """(r,) of any routes."""
        reduced: AnyArray = reduced_costs(
            routes.cost, routes.served, duals.reward, duals.fixed, duals.penalty, self.members
        )
        return reduced


def integer_solution(
    routes: Routes, requests: int, vehicles: int, upper: float, nodes_max: int
) -> AnyArray | None:
    """The best routes (indices) for all requests that a bounded search finds below `upper`."""
    lp = _quiet()
    lp.setOptionValue("mip_max_nodes", nodes_max)
    if np.isfinite(upper):
        lp.setOptionValue("objective_bound", upper)
    nothing = np.empty(0, np.int32), np.empty(0)
    for _ in range(requests):
        lp.addRow(1.0, _INF, 0, *nothing)
    lp.addRow(-_INF, float(vehicles), 0, *nothing)
    rows = np.concatenate(
        [sets_as_matrix(routes.served, requests), np.ones((len(routes), 1), np.uint8)], axis=1
    )
    of_route, row = np.nonzero(rows)
    count = len(routes)
    starts = np.searchsorted(of_route, np.arange(count)).astype(np.int32)
    lp.addCols(
        count,
        routes.cost,
        np.zeros(count),
        np.ones(count),
        len(row),
        starts,
        row.astype(np.int32),
        np.ones(len(row)),
    )
    lp.changeColsIntegrality(
        count, np.arange(count, dtype=np.int32), np.full(count, highspy.HighsVarType.kInteger)
    )
    lp.run()
    values = np.asarray(lp.getSolution().col_value)
    if len(values) != count:
        return None
    used = np.flatnonzero(values > 0.5)
    served = sets_as_matrix(routes.served[used], requests).any(axis=0)
    if not served.all() or len(used) > vehicles or routes.cost[used].sum() >= upper:
        return None
    return used


def _quiet() -> highspy.Highs:
    lp: highspy.Highs = highspy.Highs()  # type: ignore[no-untyped-call]
    lp.setOptionValue("output_flag", False)
    lp.setOptionValue("threads", 1)
    lp.setOptionValue("random_seed", 1)
    return lp
