"""Pricing: every elementary route below a threshold of reduced cost, or at least the best of them.

Labels are extended in order of time; those that cannot end below the threshold are cut by the completion
bound (completion.py). The answer is exact either way: no route below the threshold is missed unless another
one of no higher reduced cost is found.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from campusloop.studies.bound.completion import Endings, cheapest_ending, endings_of
from campusloop.studies.bound.events import EventGraph
from campusloop.studies.bound.labels import (
    Labels,
    carry_times,
    count_in_cuts,
    empty_labels,
    forget_settled_cuts,
    store_unless_dominated,
)
from campusloop.studies.bound.network import TIME_SLACK, Network
from server.dispatch.arrays import AnyArray

# What the search begins with; the way out of the depot stands in place of a label's number.
_DEPOT = -1
_FIRST_BUCKET, _NO_LABELS = 0, 0


class Prices(NamedTuple):
    """The dual values of the master problem.

    reward   (2n + 1,) >= 0, at pickups: what serving the request earns
    fixed    >= 0, what a vehicle costs
    penalty  (c,) >= 0, what a route pays that serves two or three requests of a subset-row cut
    members  (c, words) bits of the cut's three requests
    cuts_of  (n, cut words) bits of the cuts that hold the request
    """

    reward: AnyArray
    fixed: float
    penalty: AnyArray
    members: AnyArray
    cuts_of: AnyArray


class Reach(NamedTuple):
    """For every node the requests whose pickup is out of reach, by the time at which service begins there.

    times  (2n + 1, n) ascending; masks (2n + 1, n + 1, words) bit sets: past exactly k of the times, set k
    """

    times: AnyArray
    masks: AnyArray


@dataclass(frozen=True, slots=True)
class PricingResult:
    """Routes below the threshold, cheapest first.

    complete  False when the labels ran out: the routes are some of them, and nothing is proven
    threshold which it was
    reduced   (r,) reduced costs; starts (r + 1,) CSR rows of nodes; labels: how many were stored
    """

    complete: bool
    threshold: float
    labels: int
    reduced: AnyArray
    starts: AnyArray
    nodes: AnyArray


@njit(cache=True)
def reach_of(network: Network) -> Reach:
    """By the triangle inequality, what cannot be reached directly cannot be reached at all."""
    n = network.requests
    times = np.empty((2 * n + 1, n))
    masks = np.zeros((2 * n + 1, n + 1, (n + 63) // 64), np.uint64)
    for at in range(2 * n + 1):
        last = network.late[1 : n + 1] - network.service[at] - network.travel[at, 1 : n + 1] + TIME_SLACK
        order = np.argsort(last)
        for k in range(n):
            request = order[k]
            times[at, k] = last[request]
            masks[at, k + 1] = masks[at, k]
            masks[at, k + 1, request >> 6] |= np.uint64(1) << np.uint64(request & 63)
    return Reach(times, masks)


def price(
    network: Network,
    graph: EventGraph,
    reach: Reach,
    prices: Prices,
    threshold: float,
    *,
    relaxed_share: float,
    every_set: bool,
    labels_max: int,
    routes_max: int,
) -> PricingResult:
    """Routes with reduced cost below the threshold.

    relaxed_share  of the least reduced cost of the relaxation: where that is lower still, it is the
                   threshold, and far fewer labels are needed
    every_set  True: the cheapest route of every set of requests that has one. False: at least the best of all
    routes_max the cheapest so many are handed out
    """
    endings = endings_of(network, graph, prices.reward)
    if relaxed_share > 0.0:
        threshold = min(threshold, relaxed_share * _relaxed_minimum(network, graph, prices, endings))
    opening = float(network.early[1 : network.requests + 1].min())
    search = _Search(network, graph, reach, prices, endings, threshold, every_set, opening)
    count, event, parent, ends, reduced = _labels_below(search, labels_max)
    cheapest = np.argsort(reduced, kind="stable")[:routes_max]
    starts, nodes = _route_nodes(graph.node, event, parent, ends[cheapest])
    return PricingResult(
        complete=count >= 0,
        threshold=threshold,
        labels=abs(count),
        reduced=reduced[cheapest],
        starts=starts,
        nodes=nodes,
    )


@njit(cache=True)
def _relaxed_minimum(network: Network, graph: EventGraph, prices: Prices, endings: Endings) -> float:
    """No route has a lower reduced cost."""
    least = 0.0
    for request in range(network.requests):
        up = request + 1
        begin = max(network.early[up], network.early[0] + network.service[0] + network.travel[0, up])
        ending = cheapest_ending(endings, graph.first[request], begin)
        least = min(least, prices.fixed + network.travel[0, up] - prices.reward[up] + ending)
    return least


class _Search(NamedTuple):
    """The input of one pricing run; every_set, threshold as in `price`; opening: the earliest pickup."""

    network: Network
    graph: EventGraph
    reach: Reach
    prices: Prices
    endings: Endings
    threshold: float
    every_set: bool
    opening: float


@njit(cache=True)
def _labels_below(search: _Search, labels_max: int) -> tuple[int, AnyArray, AnyArray, AnyArray, AnyArray]:
    """The number of labels, negative when labels_max was too few; (l,) event and parent of each; (r,) the
    last label and the reduced cost of each route.
    """
    network, graph = search.network, search.graph
    timed = graph.aboard.shape[1] + (1 if network.duration_max < np.inf else 0)
    words, cut_words = search.reach.masks.shape[2], search.prices.cuts_of.shape[1]
    labels = empty_labels(labels_max, timed, words, cut_words)
    heads = np.full(_chains(len(graph.node), search.every_set, labels_max), -1, np.int32)
    # Each bucket holds the labels of one unit of time, and is filled again while it is worked on.
    buckets = np.full(int(network.late[1:].max() - search.opening) + 2, -1, np.int32)
    found = np.empty(1024, np.int32)
    found_cost = np.empty(1024)
    finds = 0
    # `int` makes the types the ones that they have later: numba compiles callees once more for constants.
    depot, bucket, none = int(_DEPOT), int(_FIRST_BUCKET), int(_NO_LABELS)
    count, full = _expand(search, labels, heads, buckets, depot, bucket, none)
    for bucket in range(len(buckets)):
        while not full:
            label = _next_of(labels, buckets, bucket)
            if label < 0:
                break
            event = labels.event[label]
            reduced = labels.cost[label] + network.travel[graph.node[event], 0]
            if graph.aboard[event, 0] < 0 and reduced < search.threshold:
                if finds == len(found):
                    found = np.concatenate((found, np.empty(finds, np.int32)))
                    found_cost = np.concatenate((found_cost, np.empty(finds)))
                found[finds] = label
                found_cost[finds] = reduced
                finds += 1
            count, full = _expand(search, labels, heads, buckets, label, bucket, count)
    return (
        -count if full else count,
        labels.event[:count].copy(),
        labels.parent[:count].copy(),
        found[:finds].copy(),
        found_cost[:finds].copy(),
    )


@njit(cache=True)
def _chains(events: int, every_set: bool, labels_max: int) -> int:
    """How many chains of labels that may dominate each other: one an event, or a power of two."""
    if not every_set:
        return events
    chains = 1 << 10
    while chains < min(labels_max, 1 << 22):
        chains *= 2
    return chains


@njit(cache=True)
def _next_of(labels: Labels, buckets: AnyArray, bucket: int) -> int:
    """Take the next label of a bucket that is not dominated; -1 when the bucket is empty."""
    while buckets[bucket] >= 0:
        label = int(buckets[bucket])
        buckets[bucket] = labels.bucket_next[label]
        if not labels.dead[label]:
            return label
    return -1


@njit(cache=True)
def _expand(
    search: _Search,
    labels: Labels,
    heads: AnyArray,
    buckets: AnyArray,
    label: int,
    bucket: int,
    count: int,
) -> tuple[int, bool]:
    """Extend a label, or the way out of the depot, by every event that may follow.

    Returns the number of labels after it, and whether there was no room for another one.
    """
    network, graph, prices = search.network, search.graph, search.prices
    if label < 0:
        at, choices_from, choices_to = 0, 0, network.requests
    else:
        event = int(labels.event[label])
        at = int(graph.node[event])
        choices_from, choices_to = int(graph.out_start[event]), int(graph.out_start[event + 1])
    for choice in range(choices_from, choices_to):
        if label < 0:
            child, place = graph.first[choice], 0
            leave, cost = network.early[0] + network.service[0], prices.fixed
        else:
            child, place = graph.out_event[choice], graph.out_place[choice]
            leave, cost = labels.time[label] + network.service[at], labels.cost[label]
        to = graph.node[child]
        bit = np.uint64(1) << np.uint64((to - 1) & 63)
        if label >= 0 and to <= network.requests and labels.gone[label, (to - 1) >> 6] & bit:
            continue
        begin = max(network.early[to], leave + network.travel[at, to])
        cost += network.travel[at, to] - prices.reward[to]
        if begin > network.late[to] + TIME_SLACK:
            continue
        if cost + cheapest_ending(search.endings, child, begin) >= search.threshold:
            continue
        if count == len(labels.event):
            return count, True
        if not carry_times(network, graph, labels, label, child, place, begin, count):
            continue
        if _stored(search, labels, heads, label, child, begin, cost, count):
            slot = max(bucket, int(begin - search.opening))
            labels.bucket_next[count] = buckets[slot]
            buckets[slot] = count
            count += 1
    return count, False


@njit(cache=True)
def _stored(
    search: _Search,
    labels: Labels,
    heads: AnyArray,
    label: int,
    child: int,
    begin: float,
    cost: float,
    new: int,
) -> bool:
    """Write label `new`, whose times are written; False when another label dominates it."""
    network, prices = search.network, search.prices
    to = search.graph.node[child]
    if label < 0:
        labels.gone[new] = np.uint64(0)
        labels.odd[new] = np.uint64(0)
    else:
        labels.gone[new] = labels.gone[label]
        labels.odd[new] = labels.odd[label]
    if to <= network.requests:
        labels.gone[new, (to - 1) >> 6] |= np.uint64(1) << np.uint64((to - 1) & 63)
        cost += count_in_cuts(labels, new, to - 1, prices.cuts_of, prices.penalty)
    if search.every_set:
        chain = _chain_of_set(child, labels.gone[new], len(heads))
    else:
        labels.gone[new] |= search.reach.masks[to, np.searchsorted(search.reach.times[to], begin)]
        forget_settled_cuts(labels, new, prices.members)
        chain = child
    labels.event[new] = child
    labels.parent[new] = label
    labels.time[new] = begin
    labels.cost[new] = cost
    return bool(store_unless_dominated(labels, heads, chain, new, search.every_set, prices.penalty))


@njit(cache=True)
def _chain_of_set(event: int, served: AnyArray, chains: int) -> int:
    """A hash of the event and of the set of requests served; chains is a power of two."""
    key = np.uint64(event + 1) * np.uint64(0x9E3779B97F4A7C15)
    for word in served:
        key = (key ^ word) * np.uint64(0xBF58476D1CE4E5B9)
        key ^= key >> np.uint64(31)
    return int(np.int64(key & np.uint64(chains - 1)))


@njit(cache=True)
def _route_nodes(
    node: AnyArray, event: AnyArray, parent: AnyArray, ends: AnyArray
) -> tuple[AnyArray, AnyArray]:
    """The nodes of routes without the depots, given their last labels: CSR rows (r + 1,) and nodes."""
    starts = np.zeros(len(ends) + 1, np.int64)
    for k in range(len(ends)):
        label = ends[k]
        length = 0
        while label >= 0:
            length += 1
            label = parent[label]
        starts[k + 1] = starts[k] + length
    nodes = np.empty(starts[-1], np.int32)
    for k in range(len(ends)):
        label = ends[k]
        at = starts[k + 1]
        while label >= 0:
            at -= 1
            nodes[at] = node[event[label]]
            label = parent[label]
    return starts, nodes
