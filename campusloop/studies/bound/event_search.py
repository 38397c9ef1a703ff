"""The search for every event that relaxed times allow, and for the arcs between events.

Section 3 of Gaul, Klamroth, Stiglmayr (2022) has the graph; reachability by relaxed times is ours.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from campusloop.studies.bound.network import TIME_SLACK, Network
from server.dispatch.arrays import AnyArray

# Orders of dropping off the riders that are tried before an event is accepted unchecked.
_ORDERS_MAX = 500


class EventTable(NamedTuple):
    """The events found so far; rows from `count` on are free.

    An event keeps the best of each time over all ways to it: earliest begin, most ride time left, latest
    drop-off. Together they are an optimistic label, so that no route can do what the label cannot.

    slots      (2^b,) event numbers by hash of (node, aboard), -1 free
    node (e,), earliest (e,); aboard, left, due (e, k) by place in the row
    """

    slots: AnyArray
    node: AnyArray
    aboard: AnyArray
    earliest: AnyArray
    left: AnyArray
    due: AnyArray


class Successor(NamedTuple):
    """Scratch space for the event after a step: row, left, due (k,); orders_left (1,) see `_can_finish`."""

    row: AnyArray
    left: AnyArray
    due: AnyArray
    orders_left: AnyArray


@njit(cache=True)
def reachable_events(network: Network, places: int, events_max: int) -> tuple[int, EventTable, AnyArray]:
    """All events by a worklist: how many (-1 for more than events_max), the table, and `EventGraph.first`."""
    events = _empty_table(places, events_max)
    queue = np.empty(events_max + 1, np.int64)  # a ring: an event is in it at most once
    queued = np.zeros(events_max, np.bool_)
    first = _open_routes(network, events)
    count = head = 0
    for event in first:
        queue[count] = event
        queued[event] = True
        count += 1
    length = count
    after = _successor(places)
    while length > 0:
        event = queue[head]
        head = (head + 1) % (events_max + 1)
        length -= 1
        queued[event] = False
        used, taken = _aboard(network, events, event)
        if used == 0:
            continue  # an empty vehicle opens with `first`, which has the best times already
        for choice in range(network.requests + used):
            to, place = _choice(network, events, event, choice, used, taken)
            if to < 0:
                continue
            begin = _step(network, events, event, to, place, used, after)
            if begin == np.inf:
                continue
            slot = _slot_of(events.slots, events.node, events.aboard, to, after.row)
            child = events.slots[slot]
            if child < 0:
                if count == events_max:
                    return -1, events, first
                child = count
                events.slots[slot] = child
                _enter(events, child, to, begin, after)
                count += 1
            elif not _improve(events, child, begin, after):
                continue
            if not queued[child]:
                queue[(head + length) % (events_max + 1)] = child
                queued[child] = True
                length += 1
    return count, events, first


@njit(cache=True)
def arcs_between(
    network: Network, places: int, events: EventTable, count: int
) -> tuple[int, AnyArray, AnyArray, AnyArray]:
    """The arcs among `count` events: how many; from, to (a,) events and place (a,), longer than needed."""
    arcs = 0
    arc_from = np.empty(1024, np.int32)
    arc_to = np.empty(1024, np.int32)
    arc_place = np.empty(1024, np.int8)
    after = _successor(places)
    for event in range(count):
        used, taken = _aboard(network, events, event)
        for choice in range(network.requests + used):
            to, place = _choice(network, events, event, choice, used, taken)
            if to < 0 or _step(network, events, event, to, place, used, after) == np.inf:
                continue
            child = events.slots[_slot_of(events.slots, events.node, events.aboard, to, after.row)]
            if child < 0:
                continue
            if arcs == len(arc_from):
                arc_from = np.concatenate((arc_from, np.empty(arcs, np.int32)))
                arc_to = np.concatenate((arc_to, np.empty(arcs, np.int32)))
                arc_place = np.concatenate((arc_place, np.empty(arcs, np.int8)))
            arc_from[arcs] = event
            arc_to[arcs] = child
            arc_place[arcs] = place
            arcs += 1
    return arcs, arc_from, arc_to, arc_place


@njit(cache=True)
def _empty_table(places: int, events_max: int) -> EventTable:
    bits = 1
    while (1 << bits) < 2 * events_max:
        bits += 1
    return EventTable(
        np.full(1 << bits, -1, np.int64),
        np.empty(events_max, np.int32),
        np.full((events_max, places), -1, np.int16),
        np.empty(events_max),
        np.empty((events_max, places)),
        np.empty((events_max, places)),
    )


@njit(cache=True)
def _successor(places: int) -> Successor:
    return Successor(np.empty(places, np.int16), np.empty(places), np.empty(places), np.empty(1, np.int64))


@njit(cache=True)
def _open_routes(network: Network, events: EventTable) -> AnyArray:
    """Enter the events that open a route, one a request: (n,) their numbers."""
    n, ride_max = network.requests, network.ride_max
    first = np.arange(n)
    row = np.full(events.aboard.shape[1], -1, np.int16)
    for i in range(n):
        up, home = i + 1, n + 1 + i
        row[0] = i
        events.slots[_slot_of(events.slots, events.node, events.aboard, up, row)] = i
        events.node[i] = up
        events.aboard[i] = row
        events.earliest[i] = network.early[up]
        events.left[i, 0] = network.service[up] + ride_max
        events.due[i, 0] = min(network.late[home], network.late[up] + network.service[up] + ride_max)
    return first


@njit(cache=True)
def _aboard(network: Network, events: EventTable, event: int) -> tuple[int, int]:
    """How many requests are aboard after an event, and their load."""
    used = 0
    taken = 0
    for k in range(events.aboard.shape[1]):
        if events.aboard[event, k] >= 0:
            used += 1
            taken += network.load[events.aboard[event, k] + 1]
    return used, taken


@njit(cache=True)
def _choice(
    network: Network, events: EventTable, event: int, choice: int, used: int, taken: int
) -> tuple[int, int]:
    """The node of a choice and the place in the row where its request leaves or enters; (-1, 0) for none.

    Choices are the drop-offs of the `used` requests aboard, then the pickups of all requests.
    """
    n = network.requests
    if choice < used:
        return n + 1 + events.aboard[event, choice], choice
    to = choice - used + 1
    request = to - 1
    if taken + network.load[to] > network.capacity or events.node[event] == n + to:
        return -1, 0
    place = 0
    while place < used and events.aboard[event, place] < request:
        place += 1
    if place < used and events.aboard[event, place] == request:
        return -1, 0
    return to, place


@njit(cache=True)
def _step(
    network: Network, events: EventTable, event: int, to: int, place: int, used: int, after: Successor
) -> float:
    """When the next event begins at the earliest, and `after` filled in; inf where times rule it out."""
    n, at = network.requests, events.node[event]
    step = network.service[at] + network.travel[at, to]
    begin = max(network.early[to], events.earliest[event] + step)
    latest = network.late[to]
    if begin > latest + TIME_SLACK:
        return np.inf
    if to > n:
        if events.left[event, place] - step < -TIME_SLACK:
            return np.inf
        latest = min(latest, events.due[event, place])
        if begin > latest + TIME_SLACK:
            return np.inf
    after.row[:] = -1
    after.left[:] = 0.0
    after.due[:] = 0.0
    for k in range(used):
        j = k
        if to > n:
            if k == place:
                continue
            if k > place:
                j = k - 1
        elif k >= place:
            j = k + 1
        after.row[j] = events.aboard[event, k]
        after.left[j] = events.left[event, k] - step
        after.due[j] = min(events.due[event, k], latest + after.left[j])
    if to <= n:
        after.row[place] = to - 1
        after.left[place] = network.service[to] + network.ride_max
        after.due[place] = min(network.late[n + to], latest + network.service[to] + network.ride_max)
    after.orders_left[0] = _ORDERS_MAX
    if not _can_finish(network, to, begin, after.row.copy(), after.left.copy(), after.due, after.orders_left):
        return np.inf
    return float(begin)


@njit(cache=True)
def _enter(events: EventTable, child: int, to: int, begin: float, after: Successor) -> None:
    events.node[child] = to
    events.aboard[child] = after.row
    events.earliest[child] = begin
    events.left[child] = after.left
    events.due[child] = after.due


@njit(cache=True)
def _improve(events: EventTable, child: int, begin: float, after: Successor) -> bool:
    """Keep the better of each time; whether any became better."""
    better = False
    if begin < events.earliest[child]:
        events.earliest[child] = begin
        better = True
    for k in range(len(after.row)):
        if after.row[k] >= 0:
            if after.left[k] > events.left[child, k]:
                events.left[child, k] = after.left[k]
                better = True
            if after.due[k] > events.due[child, k]:
                events.due[child, k] = after.due[k]
                better = True
    return better


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
    network: Network,
    at: int,
    time: float,
    row: AnyArray,
    left: AnyArray,
    due: AnyArray,
    orders_left: AnyArray,
) -> bool:
    """Whether some order drops off all riders in time; also true once the limit of tries is reached.

    row   (k,) requests aboard, -1 free; left (k,) ride time left at `time`; due (k,) latest drop-off
    orders_left  (1,) how many partial orders may still be tried: their number grows with the factorial
    """
    orders_left[0] -= 1
    if orders_left[0] < 0:
        return True
    has_riders = False
    for k in range(len(row)):
        if row[k] < 0:
            continue
        has_riders = True
        home = network.requests + 1 + row[k]
        arrival = time + network.service[at] + network.travel[at, home]
        if arrival > min(due[k], time + left[k]) + TIME_SLACK or arrival > network.late[home] + TIME_SLACK:
            return False
    if not has_riders:
        return True
    for k in range(len(row)):
        if row[k] < 0:
            continue
        request = row[k]
        home = network.requests + 1 + request
        step = network.service[at] + network.travel[at, home]
        row[k] = -1
        left -= step
        fine = _can_finish(network, home, time + step, row, left, due, orders_left)
        left += step
        row[k] = request
        if fine:
            return True
    return False
