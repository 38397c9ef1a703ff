"""An instance as the bound sees it: pickups 1..n, their drop-offs n+1..2n, the tightest windows."""

from typing import NamedTuple

import numpy as np

from campusloop.studies.instances.instance import Instance, InstanceBroken
from server.dispatch.arrays import AnyArray

# Larger numbers would leave too few digits behind the point for TIME_SLACK to outweigh rounding.
_LARGEST = 1e6
# Every "in time?" allows this much, so that rounding can only add routes: more routes, lower bound.
TIME_SLACK = 1e-7


class Network(NamedTuple):
    """Node 0 is the depot, pickup of request i (0-based) is node i + 1, its drop-off node n + i + 1.

    travel       (2n + 1, 2n + 1) distance and travel time
    service, early, late, load   (2n + 1,) windows are the tightest that keep every feasible route
    ride_max     longest time from the end of a pickup's service to the begin of the drop-off's
    duration_max longest route; inf where no route that keeps the windows could last longer
    nodes        (2n + 1,) index of the node in the instance

    A named tuple, for numba's kernels take it whole.
    """

    vehicles: int
    capacity: int
    requests: int
    travel: AnyArray
    service: AnyArray
    early: AnyArray
    late: AnyArray
    load: AnyArray
    ride_max: float
    duration_max: float
    nodes: AnyArray


def network_of(instance: Instance) -> Network:
    """Windows as tight as possible. Raises InstanceBroken for a request that cannot be served."""
    n = len(instance.pairs)
    if n == 0:
        raise InstanceBroken(f"{instance.name}: no requests")
    nodes = np.concatenate([[0], instance.pairs[:, 0], instance.pairs[:, 1]]).astype(np.int64)
    xy = instance.xy[nodes]
    travel = np.hypot(xy[:, None, 0] - xy[None, :, 0], xy[:, None, 1] - xy[None, :, 1])
    service = instance.service[nodes].astype(np.float64)
    # The earliest schedule of any route is a chain of legs that begins at some window's opening.
    horizon = float(instance.early[nodes].max() + service.sum() + (2 * n + 1) * travel.max())
    if not horizon < _LARGEST or not abs(float(instance.early.min())) < _LARGEST:
        raise InstanceBroken(
            f"{instance.name}: times up to {horizon:.0f}; the bound is exact below {_LARGEST:.0f}"
        )
    early, late = _tightened(instance, nodes, travel, service)
    late = np.minimum(late, horizon)
    return Network(
        vehicles=instance.vehicles,
        capacity=instance.capacity,
        requests=n,
        travel=travel,
        service=service,
        early=early,
        late=late,
        load=instance.load[nodes].astype(np.int64),
        ride_max=float(instance.ride_max),
        duration_max=_binding_duration(instance.duration_max, travel, service, early, late),
        nodes=nodes,
    )


def _tightened(
    instance: Instance, nodes: AnyArray, travel: AnyArray, service: AnyArray
) -> tuple[AnyArray, AnyArray]:
    """(2n + 1,) early and late, by the rules of Cordeau (2006), section 5.1, until nothing moves."""
    n = len(instance.pairs)
    early = np.maximum(instance.early[nodes], instance.early[0] + service[0] + travel[0])
    late = np.minimum(instance.late[nodes], instance.late[0] - service - travel[:, 0])
    early[0], late[0] = instance.early[0], instance.late[0]
    up, down = np.arange(1, n + 1), np.arange(n + 1, 2 * n + 1)
    direct = service[up] + travel[up, down]
    longest = service[up] + instance.ride_max
    # Each pair is a closed system of two variables: two passes reach the fixed point.
    for _ in range(3):
        early[down] = np.maximum(early[down], early[up] + direct)
        late[up] = np.minimum(late[up], late[down] - direct)
        early[up] = np.maximum(early[up], early[down] - longest)
        late[down] = np.minimum(late[down], late[up] + longest)
    unserved = (early[up] > late[up] + TIME_SLACK) | (early[down] > late[down] + TIME_SLACK)
    unserved |= travel[up, down] > instance.ride_max + TIME_SLACK
    # Waiting counts too: who must be picked up early and dropped late keeps the vehicle on duty between.
    shortest = travel[0, up] + np.maximum(direct, early[down] - late[up]) + service[down] + travel[down, 0]
    unserved |= shortest > instance.duration_max + TIME_SLACK
    if unserved.any():
        pickup = instance.nodes[instance.pairs[int(np.argmax(unserved)), 0]]
        raise InstanceBroken(f"{instance.name}: no route can serve the request of node {pickup}")
    return early, late


def _binding_duration(
    duration_max: float, travel: AnyArray, service: AnyArray, early: AnyArray, late: AnyArray
) -> float:
    """The longest route, or inf where none could be longer: then it need not be checked."""
    leave = (early - travel[0])[1:].min()
    back = (late + service + travel[:, 0])[1:].max()
    return duration_max if back - leave > duration_max else np.inf
