"""Scores routes of a published instance without the engine: plain Python on the instance's own rows."""

import math
from collections.abc import Sequence
from itertools import pairwise

from campusloop.studies.instances.instance import Instance

_TOLERANCE = 1e-5


class RouteBroken(ValueError):
    """A rule of the instance that the routes break."""


def rescored(instance: Instance, routes: Sequence[Sequence[int]], *, partial: bool = False) -> float:
    """Total distance of routes in node numbers, the depot left out. Raises RouteBroken.

    partial  requests may be left out, whole

    A route's times exist when its difference constraints have no negative cycle (Bellman-Ford on all of
    them).
    """
    index = {int(node): k for k, node in enumerate(instance.nodes)}
    driven = [route for route in routes if route]
    if len(driven) > instance.vehicles:
        raise RouteBroken(f"{len(driven)} routes for {instance.vehicles} vehicles")
    seen: set[int] = set()
    cost = 0.0
    for number, route in enumerate(driven, start=1):
        for node in route:
            if node not in index or node == int(instance.nodes[0]):
                raise RouteBroken(f"route {number} visits node {node}, which is none of the instance's")
            if node in seen:
                raise RouteBroken(f"node {node} is visited twice")
            seen.add(node)
        rows = [index[node] for node in route]
        _require_order_and_load(instance, number, rows)
        _require_times(instance, number, rows)
        stops = [0, *rows, 0]
        cost += sum(_distance(instance, a, b) for a, b in pairwise(stops))
    missing = set(index) - seen - {int(instance.nodes[0])}
    if missing and not partial:
        raise RouteBroken(f"{len(missing)} nodes are not visited, node {min(missing)} for one")
    return cost


def _distance(instance: Instance, a: int, b: int) -> float:
    return math.dist(instance.xy[a], instance.xy[b])


def _require_order_and_load(instance: Instance, number: int, rows: Sequence[int]) -> None:
    load = 0
    for row in rows:
        load += int(instance.load[row])
        if load > instance.capacity:
            raise RouteBroken(f"route {number} is too full at node {instance.nodes[row]}")
    at = {row: k for k, row in enumerate(rows)}
    for pickup, dropoff in instance.pairs:
        if (pickup in at) != (dropoff in at) or (pickup in at and at[pickup] > at[dropoff]):
            raise RouteBroken(f"route {number} does not carry node {instance.nodes[pickup]} to its drop-off")


def _require_times(instance: Instance, number: int, rows: Sequence[int]) -> None:
    """begin[j] >= begin[i] + gap for every rule; windows are rules against an origin at time 0."""
    stops = [0, *rows, 0]
    last = len(stops) - 1
    at = {row: k + 1 for k, row in enumerate(rows)}
    rules = [
        (k, k + 1, float(instance.service[a]) + _distance(instance, a, b))
        for k, (a, b) in enumerate(pairwise(stops))
    ]
    for pickup, dropoff in instance.pairs:
        if pickup in at and instance.ride_max < math.inf:
            longest = instance.ride_max + float(instance.service[pickup])
            rules.append((at[dropoff], at[pickup], -longest))
    if instance.duration_max < math.inf:
        rules.append((last, 0, -instance.duration_max))
    begin = [float(instance.early[row]) for row in stops]
    for _ in range(len(stops) + 1):
        moved = False
        for i, j, gap in rules:
            if begin[j] < begin[i] + gap - 1e-9:
                begin[j] = begin[i] + gap
                moved = True
        if not moved:
            break
    else:
        raise RouteBroken(f"route {number} cannot keep its ride times")
    for k, row in enumerate(stops):
        if begin[k] > float(instance.late[row]) + _TOLERANCE:
            raise RouteBroken(f"route {number} is late at node {instance.nodes[row]}")
