"""A published pickup-and-delivery instance: nodes on a plane, one depot, equal vehicles.

Distance and time are the same number: Euclidean, in double precision, in the units of the file.
"""

import math
from dataclasses import dataclass

from server.dispatch.arrays import AnyArray


class InstanceBroken(ValueError):
    """An inconsistent instance; the text names what is missing or wrong."""


@dataclass(frozen=True, slots=True)
class Instance:
    """One instance. Node 0 is the depot where every route begins and ends.

    nodes        (n,) node numbers as the file gives them, the depot first
    xy           (n, 2)
    service, load, early, late   (n,); load is positive where people or goods get in
    pairs        (r, 2) indices into `nodes`: pickup, drop-off
    ride_max     longest time between the end of the pickup's service and the start of the drop-off's, inf
                 for none; duration_max likewise between leaving the depot and being back
    revealed     (r,) when each request becomes known, or None where all are known beforehand
    fewest_vehicles_first   the number of vehicles counts before the distance
    """

    name: str
    vehicles: int
    capacity: int
    duration_max: float
    ride_max: float
    nodes: AnyArray
    xy: AnyArray
    service: AnyArray
    load: AnyArray
    early: AnyArray
    late: AnyArray
    pairs: AnyArray
    revealed: AnyArray | None = None
    fewest_vehicles_first: bool = False


def checked(instance: Instance) -> Instance:
    """The same instance. Raises InstanceBroken where a row contradicts another."""
    if instance.vehicles < 1 or instance.capacity < 1:
        raise InstanceBroken(f"{instance.name}: needs at least one vehicle with at least one place")
    if not (instance.duration_max > 0.0 and instance.ride_max > 0.0):
        raise InstanceBroken(f"{instance.name}: route duration and ride time must be positive")
    for k, node in enumerate(instance.nodes):
        values = (*instance.xy[k], instance.service[k], instance.load[k], instance.early[k])
        if not all(map(math.isfinite, values)) or math.isnan(instance.late[k]):
            raise InstanceBroken(f"{instance.name}: node {node} has a value that is not a number")
        if instance.early[k] > instance.late[k]:
            raise InstanceBroken(f"{instance.name}: the window of node {node} ends before it begins")
        if instance.service[k] < 0.0:
            raise InstanceBroken(f"{instance.name}: node {node} has a negative service time")
    if instance.load[0] != 0:
        raise InstanceBroken(f"{instance.name}: the depot has a load")
    for p, d in instance.pairs:
        pickup, dropoff = instance.nodes[p], instance.nodes[d]
        if instance.load[p] <= 0 or instance.load[d] != -instance.load[p]:
            raise InstanceBroken(
                f"{instance.name}: nodes {pickup} and {dropoff} do not carry the same load in and out"
            )
        if instance.load[p] > instance.capacity:
            raise InstanceBroken(f"{instance.name}: the load of node {pickup} fits into no vehicle")
    return instance
