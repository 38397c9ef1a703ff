"""Routes as the master problem sees them: a set of requests and a cost."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from campusloop.studies.bound.network import Network
from server.dispatch.arrays import AnyArray


@dataclass(frozen=True, slots=True)
class Routes:
    """cost (r,), served (r, words) bits of the requests, starts (r + 1,) CSR rows of nodes without the
    depots.
    """

    cost: AnyArray
    served: AnyArray
    starts: AnyArray
    nodes: AnyArray

    def __len__(self) -> int:
        return len(self.cost)

    def chosen(self, which: AnyArray) -> "Routes":
        """Those at these indices, in this order."""
        lengths = np.diff(self.starts)[which]
        starts = np.concatenate([[0], np.cumsum(lengths)])
        at = np.repeat(self.starts[which] - starts[:-1], lengths) + np.arange(starts[-1])
        return Routes(self.cost[which], self.served[which], starts, self.nodes[at])

    def joined(self, more: "Routes") -> "Routes":
        """These and then those."""
        return Routes(
            np.concatenate([self.cost, more.cost]),
            np.concatenate([self.served, more.served]),
            np.concatenate([self.starts, self.starts[-1] + more.starts[1:]]),
            np.concatenate([self.nodes, more.nodes]),
        )

    def visits(self, route: int) -> AnyArray:
        """The nodes of one route."""
        nodes: AnyArray = self.nodes[self.starts[route] : self.starts[route + 1]]
        return nodes


def routes_of(network: Network, starts: AnyArray, nodes: AnyArray) -> Routes:
    """Routes with their costs, one for each set of requests: the cheapest."""
    cost, served = _cost_and_set(network, starts, nodes)
    routes = Routes(cost, served, starts, nodes)
    by_set = np.lexsort((cost, *served.T))
    changes = np.ones(len(by_set), np.bool_)
    changes[1:] = (served[by_set[1:]] != served[by_set[:-1]]).any(axis=1)
    return routes.chosen(np.sort(by_set[changes]))


@njit(cache=True)
def _cost_and_set(network: Network, starts: AnyArray, nodes: AnyArray) -> tuple[AnyArray, AnyArray]:
    """(r,) travel from depot to depot, (r, words) bits."""
    n = network.requests
    cost = np.zeros(len(starts) - 1)
    served = np.zeros((len(starts) - 1, (n + 63) // 64), np.uint64)
    for route in range(len(cost)):
        at = 0
        for k in range(starts[route], starts[route + 1]):
            to = nodes[k]
            cost[route] += network.travel[at, to]
            if to <= n:
                served[route, (to - 1) >> 6] |= np.uint64(1) << np.uint64((to - 1) & 63)
            at = to
        cost[route] += network.travel[at, 0]
    return cost, served


def each_request_once(routes: list[AnyArray], requests: int) -> list[list[int]]:
    """Nodes of a plan whose routes (k,) may serve a request twice: all but the first time are left out.

    That keeps every rule, for the others' times can stay, and by the triangle inequality costs no more.
    """
    seen: set[int] = set()
    plan = []
    for route in routes:
        served = {(int(node) - 1) % requests for node in route}
        again = served & seen
        seen |= served
        plan.append([int(node) for node in route if (int(node) - 1) % requests not in again])
    return [route for route in plan if route]


def sets_as_matrix(served: AnyArray, requests: int) -> AnyArray:
    """(r, words) bits as an (r, n) matrix of 0 and 1."""
    as_bytes = np.ascontiguousarray(served).view(np.uint8).reshape(len(served), 8 * served.shape[1])
    matrix: AnyArray = np.unpackbits(as_bytes, axis=1, bitorder="little")[:, :requests]
    return matrix


def bits_of(members: AnyArray, requests: int) -> AnyArray:
    """(c, k) request numbers as (c, words) bits."""
    bits = np.zeros((len(members), (requests + 63) // 64), np.uint64)
    for column in members.T:
        bits[np.arange(len(members)), column >> 6] |= np.uint64(1) << (column & 63).astype(np.uint64)
    return bits


@njit(cache=True)
def _pays(served: AnyArray, route: int, members: AnyArray, cut: int) -> bool:
    """Does the route serve at least two of the cut's requests?"""
    seen = 0
    for word in range(served.shape[1]):
        common = served[route, word] & members[cut, word]
        while common != 0:
            seen += 1
            common &= common - np.uint64(1)
    return seen >= 2


@njit(cache=True)
def reduced_costs(
    cost: AnyArray, served: AnyArray, reward: AnyArray, fixed: float, penalty: AnyArray, members: AnyArray
) -> AnyArray:
    """(r,) of routes: cost (r,), served (r, words); duals: reward (n,), penalty (c,) of cuts with members
    (c, words).
    """
    reduced = np.empty(len(cost))
    for route in range(len(cost)):
        total = cost[route] + fixed
        for word in range(served.shape[1]):
            bits = served[route, word]
            request = 64 * word
            while bits != 0:
                if bits & np.uint64(1):
                    total -= reward[request]
                bits >>= np.uint64(1)
                request += 1
        for cut in range(len(penalty)):
            if penalty[cut] > 0.0 and _pays(served, route, members, cut):
                total += penalty[cut]
        reduced[route] = total
    return reduced


@njit(cache=True)
def routes_paying(served: AnyArray, members: AnyArray) -> AnyArray:
    """(r, c) whether a route serves at least two of a cut's requests."""
    pays = np.empty((len(served), len(members)), np.bool_)
    for route in range(len(served)):
        for cut in range(len(members)):
            pays[route, cut] = _pays(served, route, members, cut)
    return pays
