"""The event graph: what a vehicle has just done, and who is aboard.

An event is (node, requests aboard after it); a route is a path of events from the empty vehicle to the empty
vehicle. Precedence, pairing and capacity are in the graph, times are not: those are the labels' (pricing).
After Gaul, Klamroth, Stiglmayr (2022), section 3; reachability by relaxed times is ours.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from campusloop.studies.bound.network import TIME_SLACK, Network
from server.dispatch.arrays import AnyArray

# Orders of bringing people home that are looked at before an event is let in unseen.
_PATIENCE = 500


class EventGraph(NamedTuple):
    """Events and their arcs, both as flat arrays.

    node       (e,) the node of the event
    aboard     (e, k) requests aboard after it, ascending, -1 where a place in the row is free
    earliest   (e,) no route is there before
    first      (n,) the event that opens a route or follows an empty vehicle: pickup i with only i aboard
    out_start, in_start   (e + 1,) CSR rows of out_event/out_place and in_event
    out_place  the place in `aboard` where the request enters (pickup) or from which it leaves (drop-off)
    """

    node: AnyArray
    aboard: AnyArray
    earliest: AnyArray
    first: AnyArray
    out_start: AnyArray
    out_event: AnyArray
    out_place: AnyArray
    in_start: AnyArray
    in_event: AnyArray


class TooManyEvents(Exception):
    """The graph would outgrow its limit: far more people fit together than in the published instances."""


def event_graph(network: Network, events_max: int) -> EventGraph:
    """Every event that relaxed times allow. Raises TooManyEvents."""
    n = network.requests
    loads = np.sort(network.load[1 : n + 1])
    places = int(np.searchsorted(np.cumsum(loads), network.capacity, side="right"))
    count, node, aboard, earliest, first, arcs, arc_from, arc_to, arc_place = _explore(
        network, places, events_max
    )
    if count < 0:
        raise TooManyEvents(
            f"more than {events_max} events (a stop, and who is aboard after it): "
            "the windows are too wide and the places too many for this bound"
        )
    arc_from, arc_to, arc_place = arc_from[:arcs], arc_to[:arcs], arc_place[:arcs]
    order = np.argsort(arc_from, kind="stable")
    back = np.argsort(arc_to, kind="stable")
    return EventGraph(
        node=node[:count].copy(),
        aboard=aboard[:count].copy(),
        earliest=earliest[:count].copy(),
        first=first,
        out_start=np.searchsorted(arc_from[order], np.arange(count + 1)).astype(np.int64),
        out_event=arc_to[order].copy(),
        out_place=arc_place[order].copy(),
        in_start=np.searchsorted(arc_to[back], np.arange(count + 1)).astype(np.int64),
        in_event=arc_from[back].copy(),
    )


@njit(cache=True)
def _slot_of(table: AnyArray, node: AnyArray, aboard: AnyArray, at: int, row: AnyArray) -> int:
    """Where (at, row) is in the open-addressing table, or the free slot where it belongs.

    table  (2^b,) event numbers, -1 free; aboard (events_max, k); row (k,)
    """
    mask = len(table) - 1
    mixed = np.uint64(at + 1)
    for r in row:
        mixed = (mixed ^ np.uint64(r + 2)) * np.uint64(0x9E3779B97F4A7C15)
        mixed ^= mixed >> np.uint64(29)
    slot = np.int64(mixed & np.uint64(mask))
    while table[slot] >= 0:
        event = table[slot]
        if node[event] == at:
            same = True
            for k in range(len(row)):
                if aboard[event, k] != row[k]:
                    same = False
                    break
            if same:
                return int(slot)
        slot = (slot + 1) & mask
    return int(slot)


@njit(cache=True)
def _can_finish(
    network: Network, at: int, time: float, row: AnyArray, left: AnyArray, due: AnyArray, patience: AnyArray
) -> bool:
    """Can everybody aboard be brought home in some order? True as well when patience runs out first.

    row   (k,) requests aboard, -1 free; left (k,) ride time left at `time`; due (k,) latest drop-off
    patience   (1,) how many partial orders may be looked at: their number grows with the factorial
    """
    patience[0] -= 1
    if patience[0] < 0:
        return True
    anybody = False
    for k in range(len(row)):
        if row[k] < 0:
            continue
        anybody = True
        home = network.requests + 1 + row[k]
        arrival = time + network.service[at] + network.travel[at, home]
        if arrival > min(due[k], time + left[k]) + TIME_SLACK or arrival > network.late[home] + TIME_SLACK:
            return False
    if not anybody:
        return True
    for k in range(len(row)):
        if row[k] < 0:
            continue
        request = row[k]
        home = network.requests + 1 + request
        step = network.service[at] + network.travel[at, home]
        row[k] = -1
        left -= step
        fine = _can_finish(network, home, time + step, row, left, due, patience)
        left += step
        row[k] = request
        if fine:
            return True
    return False


@njit(cache=True)
def _explore(
    network: Network, places: int, events_max: int
) -> tuple[int, AnyArray, AnyArray, AnyArray, AnyArray, int, AnyArray, AnyArray, AnyArray]:
    """Events by a worklist; count is -1 when they outgrow events_max.

    An event keeps the best of each time over all ways to it (earliest begin, most ride time left, latest
    drop-off): together an optimistic label, so that what it cannot do, no route can.
    """
    n, ride_max = network.requests, network.ride_max
    travel, service, early, late = network.travel, network.service, network.early, network.late
    load, capacity = network.load, network.capacity
    bits = 1
    while (1 << bits) < 2 * events_max:
        bits += 1
    table = np.full(1 << bits, -1, np.int64)
    node = np.empty(events_max, np.int32)
    aboard = np.full((events_max, places), -1, np.int16)
    earliest = np.empty(events_max)
    left = np.empty((events_max, places))
    due = np.empty((events_max, places))
    queued = np.zeros(events_max, np.bool_)
    queue = np.empty(events_max + 1, np.int64)  # a ring: an event is in it at most once
    head, length, count = 0, 0, 0
    first = np.empty(n, np.int64)
    row = np.empty(places, np.int16)
    new_left = np.empty(places)
    new_due = np.empty(places)
    patience = np.empty(1, np.int64)

    for i in range(n):
        row[:] = -1
        row[0] = i
        slot = _slot_of(table, node, aboard, i + 1, row)
        table[slot] = count
        node[count] = i + 1
        aboard[count] = row
        earliest[count] = early[i + 1]
        left[count, 0] = service[i + 1] + ride_max
        due[count, 0] = min(late[n + 1 + i], late[i + 1] + service[i + 1] + ride_max)
        first[i] = count
        queue[i] = count
        queued[count] = True
        count += 1
    length = n

    arcs = 0
    arcs_max = 1024
    arc_from = np.empty(arcs_max, np.int32)
    arc_to = np.empty(arcs_max, np.int32)
    arc_place = np.empty(arcs_max, np.int8)

    # Pass 0 finds the events and their times, pass 1 goes over each once and writes the arcs.
    for writing in range(2):
        if writing:
            for event in range(count):
                queue[event] = event
            head, length = 0, count
        while length > 0:
            event = queue[head]
            head = (head + 1) % (events_max + 1)
            length -= 1
            queued[event] = False
            at = node[event]
            used = 0
            taken = 0
            for k in range(places):
                if aboard[event, k] >= 0:
                    used += 1
                    taken += load[aboard[event, k] + 1]
            if used == 0 and not writing:
                continue  # an empty vehicle opens with `first`, which has the best times already
            for choice in range(n + used):
                if choice < used:
                    place = choice
                    to = n + 1 + aboard[event, place]
                else:
                    to = choice - used + 1
                    request = to - 1
                    if taken + load[to] > capacity or at == n + to:
                        continue
                    place = 0
                    while place < used and aboard[event, place] < request:
                        place += 1
                    if place < used and aboard[event, place] == request:
                        continue
                step = service[at] + travel[at, to]
                begin = max(early[to], earliest[event] + step)
                if begin > late[to] + TIME_SLACK:
                    continue
                latest = late[to]
                if to > n:
                    if left[event, place] - step < -TIME_SLACK:
                        continue
                    latest = min(latest, due[event, place])
                    if begin > latest + TIME_SLACK:
                        continue
                row[:] = -1
                new_left[:] = 0.0
                new_due[:] = 0.0
                for k in range(used):
                    j = k
                    if to > n:
                        if k == place:
                            continue
                        if k > place:
                            j = k - 1
                    elif k >= place:
                        j = k + 1
                    row[j] = aboard[event, k]
                    new_left[j] = left[event, k] - step
                    new_due[j] = min(due[event, k], latest + new_left[j])
                if to <= n:
                    row[place] = to - 1
                    new_left[place] = service[to] + ride_max
                    new_due[place] = min(late[n + to], latest + service[to] + ride_max)
                patience[0] = _PATIENCE
                if not _can_finish(network, to, begin, row.copy(), new_left.copy(), new_due, patience):
                    continue
                slot = _slot_of(table, node, aboard, to, row)
                child = table[slot]
                if writing:
                    if child < 0:
                        continue
                    if arcs == arcs_max:
                        arc_from = np.concatenate((arc_from, np.empty(arcs_max, np.int32)))
                        arc_to = np.concatenate((arc_to, np.empty(arcs_max, np.int32)))
                        arc_place = np.concatenate((arc_place, np.empty(arcs_max, np.int8)))
                        arcs_max *= 2
                    arc_from[arcs] = event
                    arc_to[arcs] = child
                    arc_place[arcs] = place
                    arcs += 1
                    continue
                better = False
                if child < 0:
                    if count == events_max:
                        return -1, node, aboard, earliest, first, 0, arc_from, arc_to, arc_place
                    child = count
                    table[slot] = child
                    node[child] = to
                    aboard[child] = row
                    earliest[child] = begin
                    left[child] = new_left
                    due[child] = new_due
                    count += 1
                    better = True
                else:
                    if begin < earliest[child]:
                        earliest[child] = begin
                        better = True
                    for k in range(places):
                        if row[k] >= 0:
                            if new_left[k] > left[child, k]:
                                left[child, k] = new_left[k]
                                better = True
                            if new_due[k] > due[child, k]:
                                due[child, k] = new_due[k]
                                better = True
                if better and not queued[child]:
                    queue[(head + length) % (events_max + 1)] = child
                    queued[child] = True
                    length += 1
    return count, node, aboard, earliest, first, arcs, arc_from, arc_to, arc_place
