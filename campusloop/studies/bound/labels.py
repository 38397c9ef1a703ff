"""Labels: paths through the event graph with exact times, and when one makes another superfluous.

For every request aboard a label has the latest drop-off as a function of the time at which service begins
here: min(due, time + left). That is exact for ride-time limits (Gschwind, Irnich 2015, section 4). A limit of
the route's duration is one more passenger, who rides from depot to depot.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from campusloop.studies.bound.events import EventGraph
from campusloop.studies.bound.network import TIME_SLACK, Network
from server.dispatch.arrays import AnyArray


class Labels(NamedTuple):
    """A store of labels, row by row.

    event, parent  (l,) parent -1 at a route's first event
    time, cost     (l,) earliest begin of service; reduced cost so far
    left, due      (l, places + 1 where the route's duration is limited, else places)
    gone           (l, words) bits of requests that must not be served any more
    odd            (l, cut words) bits of the subset-row cuts of which an odd number of requests was served
    dead           (l,) dominated after it was stored
    chain_next     (l,) the next label that can be compared, by cost; bucket_next (l,) the next to be extended
    """

    event: AnyArray
    parent: AnyArray
    time: AnyArray
    cost: AnyArray
    left: AnyArray
    due: AnyArray
    gone: AnyArray
    odd: AnyArray
    dead: AnyArray
    chain_next: AnyArray
    bucket_next: AnyArray


@njit(cache=True)
def empty_labels(size: int, timed: int, words: int, cut_words: int) -> Labels:
    """Room for labels; pages are only touched when they are used."""
    return Labels(
        np.empty(size, np.int32),
        np.empty(size, np.int32),
        np.empty(size),
        np.empty(size),
        np.empty((size, timed)),
        np.empty((size, timed)),
        np.empty((size, words), np.uint64),
        np.empty((size, cut_words), np.uint64),
        np.zeros(size, np.bool_),
        np.empty(size, np.int32),
        np.empty(size, np.int32),
    )


@njit(cache=True)
def carry_times(
    network: Network,
    graph: EventGraph,
    labels: Labels,
    label: int,
    child: int,
    place: int,
    begin: float,
    new: int,
) -> bool:
    """Write `left` and `due` of the label that goes on to event `child`; False where one would be late.

    label -1 is the depot; place: where the request enters or leaves `aboard`; begin: of service at the child
    """
    n = network.requests
    to = graph.node[child]
    places = graph.aboard.shape[1]
    timed = labels.left.shape[1]
    left, due = labels.left, labels.due
    latest = network.late[to]
    for k in range(timed):
        left[new, k] = 0.0
        due[new, k] = 0.0
    if label >= 0:
        event = labels.event[label]
        at = graph.node[event]
        step = network.service[at] + network.travel[at, to]
        if to > n:
            if left[label, place] - step < -TIME_SLACK:
                return False
            latest = min(latest, due[label, place])
        for k in range(places):
            if graph.aboard[event, k] < 0:
                break
            j = k
            if to > n:
                if k == place:
                    continue
                if k > place:
                    j = k - 1
            elif k >= place:
                j = k + 1
            left[new, j] = left[label, k] - step
            due[new, j] = due[label, k]
        if timed > places:
            left[new, places] = left[label, places] - step
            due[new, places] = due[label, places]
    elif timed > places:
        left[new, places] = network.duration_max - network.travel[0, to]
        due[new, places] = network.late[0]
    if to <= n:
        left[new, place] = network.service[to] + network.ride_max
        due[new, place] = network.late[n + to]

    if begin > latest + TIME_SLACK:
        return False
    for k in range(timed):
        if k < places:
            if graph.aboard[child, k] < 0:
                continue
            home = n + 1 + graph.aboard[child, k]
        else:
            home = 0
        way = network.service[to] + network.travel[to, home]
        if left[new, k] < way - TIME_SLACK or begin + way > due[new, k] + TIME_SLACK:
            return False
        latest = min(latest, due[new, k] - way)
    # Service cannot begin here after `latest`, whatever follows: later drop-offs are out of reach too.
    for k in range(timed):
        if k == places or graph.aboard[child, k] >= 0:
            due[new, k] = min(due[new, k], latest + left[new, k])
    return True


@njit(cache=True)
def _lowest_bit(bits: np.uint64) -> int:
    """The number of the lowest bit that is set; bits must not be 0."""
    place = 0
    for shift in (32, 16, 8, 4, 2, 1):
        if bits & ((np.uint64(1) << np.uint64(shift)) - np.uint64(1)) == 0:
            bits >>= np.uint64(shift)
            place += shift
    return place


@njit(cache=True)
def count_in_cuts(labels: Labels, new: int, request: int, cuts_of: AnyArray, penalty: AnyArray) -> float:
    """Turn the parities of the cuts that hold the request; what the second request of a cut costs.

    cuts_of (n, cut words), penalty (c,) >= 0
    """
    cost = 0.0
    for word in range(cuts_of.shape[1]):
        again = labels.odd[new, word] & cuts_of[request, word]
        labels.odd[new, word] ^= cuts_of[request, word]
        while again != 0:
            cost += penalty[64 * word + _lowest_bit(again)]
            again &= again - np.uint64(1)
    return cost


@njit(cache=True)
def forget_settled_cuts(labels: Labels, new: int, members: AnyArray) -> None:
    """An odd cut none of whose requests can come any more is as good as an even one. members (c, words)."""
    for word in range(labels.odd.shape[1]):
        bits = labels.odd[new, word]
        while bits != 0:
            lowest = bits & (~bits + np.uint64(1))
            cut = 64 * word + _lowest_bit(bits)
            settled = True
            for k in range(members.shape[1]):
                if members[cut, k] & ~labels.gone[new, k]:
                    settled = False
                    break
            if settled:
                labels.odd[new, word] ^= lowest
            bits ^= lowest


@njit(cache=True)
def dominates(labels: Labels, a: int, b: int, same_set: bool, penalty: AnyArray) -> bool:
    """Whatever label b can become, a can become too, for no more. Both are at the same event.

    same_set  compare only labels that served the same requests
    penalty   (c,) of the subset-row cuts: a may yet pay those that are odd in a and even in b
              (Jepsen, Petersen, Spoorendonk, Pisinger 2008, proposition 5)
    """
    if (
        labels.event[a] != labels.event[b]
        or labels.cost[a] > labels.cost[b]
        or labels.time[a] > labels.time[b]
    ):
        return False
    for word in range(labels.gone.shape[1]):
        if same_set:
            if labels.gone[a, word] != labels.gone[b, word]:
                return False
        elif labels.gone[a, word] & ~labels.gone[b, word]:
            return False
    begin = labels.time[b]
    for k in range(labels.left.shape[1]):
        due_a, due_b = labels.due[a, k], labels.due[b, k]
        if due_a < due_b:
            return False
        if min(due_a, begin + labels.left[a, k]) < min(due_b, begin + labels.left[b, k]):
            return False
    if not same_set:
        cost = labels.cost[a]
        for word in range(labels.odd.shape[1]):
            bits = labels.odd[a, word] & ~labels.odd[b, word]
            while bits != 0:
                cost += penalty[64 * word + _lowest_bit(bits)]
                bits &= bits - np.uint64(1)
        return bool(cost <= labels.cost[b])
    return True


@njit(cache=True)
def store_unless_dominated(
    labels: Labels, heads: AnyArray, chain: int, new: int, same_set: bool, penalty: AnyArray
) -> bool:
    """Put the label into its chain, which is sorted by cost: the cheaper may dominate it, it the dearer."""
    before, other = -1, heads[chain]
    while other >= 0 and labels.cost[other] <= labels.cost[new]:
        if dominates(labels, other, new, same_set, penalty):
            return False
        before = other
        other = labels.chain_next[other]
    labels.chain_next[new] = other
    if before < 0:
        heads[chain] = new
    else:
        labels.chain_next[before] = new
    before = new
    while other >= 0:
        after = labels.chain_next[other]
        if dominates(labels, new, other, same_set, penalty):
            labels.dead[other] = True
            labels.chain_next[before] = after
        else:
            before = other
        other = after
    return True
