"""The relaxation, its cuts and what its duals prove, on a plan that fractions beat."""

import itertools

import numpy as np
import pytest

from campusloop.studies.bound.cuts import violated_cuts
from campusloop.studies.bound.master import (
    Duals,
    Master,
    integer_solution,
    lagrangian_bound,
)
from campusloop.studies.bound.routes import Routes, each_request_once, sets_as_matrix

REQUESTS, VEHICLES = 3, 3


def pairs_and_singles() -> Routes:
    """Any two of three requests together for 10, each alone for 9: half of every pair serves all for 15."""
    sets = [*itertools.combinations(range(REQUESTS), 2), (0,), (1,), (2,)]
    served = np.array([[sum(1 << i for i in members)] for members in sets], np.uint64)
    starts = np.cumsum([0, *(2 * len(members) for members in sets)])
    nodes = [node for members in sets for i in members for node in (i + 1, i + 1 + REQUESTS)]
    return Routes(np.array([10.0, 10.0, 10.0, 9.0, 9.0, 9.0]), served, starts, np.array(nodes))


def filled() -> Master:
    master = Master(REQUESTS, VEHICLES, unserved_cost=100.0)
    assert master.add_routes(pairs_and_singles()) == 6
    return master


def test_a_cut_takes_the_fractions_away() -> None:
    master = filled()
    relaxed = master.solve()
    assert relaxed.value == pytest.approx(15.0)
    assert relaxed.flow == pytest.approx([0.5, 0.5, 0.5, 0.0, 0.0, 0.0])
    sets = sets_as_matrix(master.routes.served, REQUESTS)
    cuts = violated_cuts(sets, relaxed.flow, set(), 10, 10, 0.01)
    assert cuts.tolist() == [[0, 1, 2]]
    assert len(violated_cuts(sets, relaxed.flow, {(0, 1, 2)}, 10, 10, 0.01)) == 0
    master.add_cuts(cuts)
    assert master.solve().value == pytest.approx(19.0)
    chosen = integer_solution(master.routes, REQUESTS, VEHICLES, np.inf, 10)
    assert chosen is not None
    assert master.routes.cost[chosen].sum() == 19.0


def test_duals_prove_the_relaxation_and_never_more() -> None:
    master = filled()
    relaxed = master.solve()
    master.add_cuts(np.array([[0, 1, 2]]))
    cut = master.solve()
    for duals, value in ((relaxed.duals, 15.0), (cut.duals, 19.0)):
        least = float(master.reduced_costs(master.routes, duals).min())
        proven = lagrangian_bound(duals, VEHICLES, least)
        assert value - 1e-5 < proven < value


@pytest.mark.parametrize("seed", range(20))
def test_any_duals_prove_a_bound(seed: int) -> None:
    master = filled()
    master.add_cuts(np.array([[0, 1, 2]]))
    rng = np.random.default_rng(seed)
    duals = Duals(rng.uniform(0.0, 20.0, REQUESTS), rng.uniform(0.0, 9.0), rng.uniform(0.0, 9.0, 1))
    least = float(master.reduced_costs(master.routes, duals).min())
    assert lagrangian_bound(duals, VEHICLES, least) < 19.0


def test_a_cheaper_route_of_the_same_requests_is_new_and_a_dearer_one_is_not() -> None:
    master = filled()
    same = pairs_and_singles()
    assert master.add_routes(same) == 0
    assert master.add_routes(Routes(same.cost - 1.0, same.served, same.starts, same.nodes)) == 6
    assert master.solve().value == pytest.approx(13.5)


def test_dropped_routes_are_those_of_the_greatest_reduced_cost() -> None:
    master = filled()
    master.keep_cheapest(master.solve().duals, 3)
    assert master.routes.cost.tolist() == [10.0, 10.0, 10.0]
    assert master.solve().value == pytest.approx(15.0)


def test_who_is_served_twice_is_left_out_of_the_second_route() -> None:
    routes = [np.array([1, 2, 4, 5]), np.array([2, 3, 5, 6]), np.array([1, 4])]
    assert each_request_once(routes, REQUESTS) == [[1, 2, 4, 5], [3, 6]]
