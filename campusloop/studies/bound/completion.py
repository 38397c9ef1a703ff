"""How cheaply a route can end: a lower bound of what follows an event, by time.

Backward over the event graph with windows alone. Ride times are forgotten and a request may be served
twice, so the truth is never cheaper. The bound is a falling staircase in the latest time at which the event
may begin.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from campusloop.studies.bound.events import EventGraph
from campusloop.studies.bound.network import TIME_SLACK, Network
from server.dispatch.arrays import AnyArray

# Steps that are searched: about 350 MB.
_STEPS_MAX = 8_000_000


class Endings(NamedTuple):
    """Staircases of all events.

    starts       (e + 1,) CSR rows
    times, costs (s,) falling along each row: from event e at time t the cheapest ending costs no less than
                 the last of e's steps whose time is >= t, and there is no ending when no step is
    """

    starts: AnyArray
    times: AnyArray
    costs: AnyArray


@njit(cache=True)
def _sift_up(heap_time: AnyArray, heap_step: AnyArray, at: int) -> None:
    """Restore the order of a heap with the latest time on top, after an entry was put at the end."""
    while at > 0:
        above = (at - 1) >> 1
        if heap_time[above] >= heap_time[at]:
            break
        heap_time[above], heap_time[at] = heap_time[at], heap_time[above]
        heap_step[above], heap_step[at] = heap_step[at], heap_step[above]
        at = above


@njit(cache=True)
def _sift_down(heap_time: AnyArray, heap_step: AnyArray, size: int) -> None:
    """Restore the order after the top was replaced."""
    at = 0
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and heap_time[below + 1] > heap_time[below]:
            below += 1
        if heap_time[at] >= heap_time[below]:
            break
        heap_time[below], heap_time[at] = heap_time[at], heap_time[below]
        heap_step[below], heap_step[at] = heap_step[at], heap_step[below]
        at = below


@njit(cache=True)
def endings_of(network: Network, graph: EventGraph, reward: AnyArray) -> Endings:
    """The staircases under these rewards, (2n + 1,), for serving a node. Label setting, latest time first.

    Served again and again in no time, requests would earn without end: no ending costs less than all the
    rewards together, and after _STEPS_MAX steps that is all that is said of earlier times.
    """
    floor = -reward.sum()
    travel, service, late = network.travel, network.service, network.late
    node, aboard, earliest = graph.node, graph.aboard, graph.earliest
    in_start, in_event = graph.in_start, graph.in_event
    events = len(node)
    cap = max(1 << 16, events)
    heap_time = np.empty(cap)
    heap_step = np.empty(cap, np.int64)
    step_event = np.empty(cap, np.int32)
    step_time = np.empty(cap)
    step_cost = np.empty(cap)
    kept = np.empty(cap, np.int64)
    best = np.full(events, np.inf)
    sizes = np.zeros(events + 1, np.int64)
    size, made, keeps = 0, 0, 0
    for event in range(events):
        if aboard[event, 0] < 0:
            step_event[made] = event
            step_time[made] = late[node[event]]
            step_cost[made] = travel[node[event], 0]
            heap_time[size] = step_time[made]
            heap_step[size] = made
            _sift_up(heap_time, heap_step, size)
            size += 1
            made += 1
    given_up = -np.inf
    while size > 0:
        step = heap_step[0]
        size -= 1
        heap_time[0] = heap_time[size]
        heap_step[0] = heap_step[size]
        _sift_down(heap_time, heap_step, size)
        event = step_event[step]
        cost = step_cost[step]
        if made >= _STEPS_MAX:
            given_up = step_time[step]
            break
        if cost >= best[event]:
            continue
        best[event] = cost
        kept[keeps] = step
        keeps += 1
        sizes[event + 1] += 1
        at = node[event]
        for arc in range(in_start[event], in_start[event + 1]):
            before = in_event[arc]
            begin = node[before]
            time = min(step_time[step] - service[begin] - travel[begin, at], late[begin])
            if time < earliest[before] - TIME_SLACK:
                continue
            total = max(floor, cost + travel[begin, at] - reward[at])
            if total >= best[before]:
                continue
            if made == cap:
                # Doubling by copies: the heap never holds more than was made.
                heap_time = np.concatenate((heap_time, np.empty(cap)))
                heap_step = np.concatenate((heap_step, np.empty(cap, np.int64)))
                step_event = np.concatenate((step_event, np.empty(cap, np.int32)))
                step_time = np.concatenate((step_time, np.empty(cap)))
                step_cost = np.concatenate((step_cost, np.empty(cap)))
                kept = np.concatenate((kept, np.empty(cap, np.int64)))
                cap *= 2
            step_event[made] = before
            step_time[made] = time
            step_cost[made] = total
            heap_time[size] = time
            heap_step[size] = made
            _sift_up(heap_time, heap_step, size)
            size += 1
            made += 1
    return _staircases(sizes, kept[:keeps], step_event, step_time, step_cost, given_up, floor)


@njit(cache=True)
def _staircases(
    sizes: AnyArray,
    kept: AnyArray,
    step_event: AnyArray,
    step_time: AnyArray,
    step_cost: AnyArray,
    given_up: float,
    floor: float,
) -> Endings:
    """The kept steps sorted by event, in the order in which they were kept.

    sizes     (e + 1,) steps of each event, after a leading 0
    given_up  before this time `floor` is all that is said; -inf when the search ended by itself
    """
    if given_up > -np.inf:
        sizes[1:] += 1
    starts = np.cumsum(sizes)
    fill = starts.copy()
    times = np.empty(starts[-1])
    costs = np.empty(starts[-1])
    for k in range(len(kept)):
        event = step_event[kept[k]]
        times[fill[event]] = step_time[kept[k]]
        costs[fill[event]] = step_cost[kept[k]]
        fill[event] += 1
    if given_up > -np.inf:
        for event in range(len(sizes) - 1):
            times[fill[event]] = given_up
            costs[fill[event]] = floor
    return Endings(starts, times, costs)


@njit(cache=True)
def cheapest_ending(endings: Endings, event: int, time: float) -> float:
    """No route that begins this event at this time ends for less; inf where none ends at all."""
    low, high = endings.starts[event], endings.starts[event + 1]
    while low < high:
        middle = (low + high) >> 1
        if endings.times[middle] >= time - TIME_SLACK:
            low = middle + 1
        else:
            high = middle
    if low == endings.starts[event]:
        return np.inf
    return float(endings.costs[low - 1])
