"""Pricing against every route that there is."""

import itertools

import numpy as np
import pytest

from campusloop.studies.bound.completion import cheapest_ending, endings_of
from campusloop.studies.bound.events import event_graph
from campusloop.studies.bound.network import network_of
from campusloop.studies.bound.pricing import Prices, price, reach_of
from campusloop.studies.bound.routes import bits_of, routes_of, sets_as_matrix
from campusloop.studies.instances.instance import Instance
from tests.campusloop.studies.bound.small_instances import all_routes, cost_of, seeded_instance

_THRESHOLD = 20.0
# Those among the first in which each request can be served alone.
SEEDS = [0, 1, 2, 3, 7, 8, 9, 11, 12, 13, 14, 16]


def cheapest_by_set(instance: Instance) -> dict[frozenset[int], float]:
    """Requests served -> the least distance of a route that serves just them."""
    n = len(instance.pairs)
    cheapest: dict[frozenset[int], float] = {}
    for route in all_routes(instance):
        served = frozenset(node - 1 for node in route if node <= n)
        cheapest[served] = min(cheapest.get(served, np.inf), cost_of(instance, route))
    return cheapest


def with_cuts(rng: np.random.Generator, n: int) -> tuple[Prices, list[frozenset[int]]]:
    """Prices at which some routes pay, and every triple of requests as a cut, if there are any."""
    triples = np.array(list(itertools.combinations(range(n), 3)), np.int64).reshape(-1, 3)
    reward = np.zeros(2 * n + 1)
    reward[1 : n + 1] = rng.uniform(0.0, 30.0, n)
    cuts_of = np.zeros((n, (len(triples) + 63) // 64), np.uint64)
    for k, triple in enumerate(triples):
        cuts_of[triple, k >> 6] |= np.uint64(1) << np.uint64(k & 63)
    prices = Prices(reward, 2.0, rng.uniform(0.0, 8.0, len(triples)), bits_of(triples, n), cuts_of)
    return prices, [frozenset(triple.tolist()) for triple in triples]


@pytest.mark.parametrize("seed", SEEDS)
def test_every_set_is_found_with_its_reduced_cost_and_the_best_route_without(seed: int) -> None:
    instance = seeded_instance(seed)
    network = network_of(instance)
    graph, reach = event_graph(network, 100_000), reach_of(network)
    prices, triples = with_cuts(np.random.default_rng(seed), network.requests)
    wanted = {}
    for served, cost in cheapest_by_set(instance).items():
        earned = sum(prices.reward[request + 1] for request in served)
        paid = sum(p for p, t in zip(prices.penalty, triples, strict=True) if len(t & served) >= 2)
        if cost + 2.0 - earned + paid < _THRESHOLD:
            wanted[served] = cost + 2.0 - earned + paid
    for every_set in (True, False):
        priced = price(
            network,
            graph,
            reach,
            prices,
            _THRESHOLD,
            relaxed_share=0.0,
            every_set=every_set,
            labels_max=50_000,
            routes_max=10_000,
        )
        assert priced.complete
        if not every_set:
            assert priced.reduced.min(initial=np.inf) == pytest.approx(min(wanted.values(), default=np.inf))
            continue
        routes = routes_of(network, priced.starts, priced.nodes)
        found = sets_as_matrix(routes.served, network.requests)
        sets = {frozenset(np.flatnonzero(row).tolist()) for row in found}
        assert sets == set(wanted)
        assert priced.reduced.min(initial=np.inf) == pytest.approx(min(wanted.values(), default=np.inf))


def test_places_that_coincide_end_for_no_less_than_all_rewards() -> None:
    """Served again and again in no time, a request would earn without end."""
    instance = seeded_instance(3)
    instance.xy[:] = 0.0
    instance.service[:] = 0.0
    instance.early[:] = 0.0
    instance.late[1:] = 30.0
    network = network_of(instance)
    graph = event_graph(network, 100_000)
    reward = np.zeros(len(network.early))
    reward[1 : network.requests + 1] = 3.0
    endings = endings_of(network, graph, reward)
    ends = [cheapest_ending(endings, int(first), 0.0) for first in graph.first]
    assert max(ends) <= 0.0
    assert min(ends) >= -3.0 * network.requests
