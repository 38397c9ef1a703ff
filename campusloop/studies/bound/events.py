"""The event graph: a stop, and the requests aboard after it.

An event is (node, requests aboard after it); a route is a path of events from the empty vehicle to the empty
vehicle. Precedence, pairing and capacity are in the graph, times are not: those are the labels' (pricing).
After Gaul, Klamroth, Stiglmayr (2022), section 3; reachability by relaxed times is ours.
"""

from typing import NamedTuple

import numpy as np

from campusloop.studies.bound.event_search import arcs_between, reachable_events
from campusloop.studies.bound.network import Network
from server.dispatch.arrays import AnyArray


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
    count, events, first = reachable_events(network, places, events_max)
    if count < 0:
        raise TooManyEvents(
            f"more than {events_max} events (a stop, and the riders aboard after it): "
            "the windows are too wide and the places too many for this bound"
        )
    arcs, arc_from, arc_to, arc_place = arcs_between(network, places, events, count)
    arc_from, arc_to, arc_place = arc_from[:arcs], arc_to[:arcs], arc_place[:arcs]
    order = np.argsort(arc_from, kind="stable")
    back = np.argsort(arc_to, kind="stable")
    return EventGraph(
        node=events.node[:count].copy(),
        aboard=events.aboard[:count].copy(),
        earliest=events.earliest[:count].copy(),
        first=first,
        out_start=np.searchsorted(arc_from[order], np.arange(count + 1)).astype(np.int64),
        out_event=arc_to[order].copy(),
        out_place=arc_place[order].copy(),
        in_start=np.searchsorted(arc_to[back], np.arange(count + 1)).astype(np.int64),
        in_event=arc_from[back].copy(),
    )
