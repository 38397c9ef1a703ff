"""Converts a published instance to a task, and a plan's routes to the instance's node numbers."""

import numpy as np

from campusloop.studies.instances.instance import Instance
from campusloop.studies.instances.windows import tightened
from server.dispatch.arrays import AnyArray
from server.dispatch.engine.plan import Plan
from server.dispatch.engine.task import LOAD_KINDS, Task


def task_of(instance: Instance, absent_cost: float | None = None) -> Task:
    """absent_cost  of an unserved request; by default more than any plan can save by it."""
    pairs = np.ravel(instance.pairs)
    n, vehicles = len(pairs), instance.vehicles
    rows = np.concatenate([pairs, np.zeros(2 * vehicles, np.int64)])
    xy = instance.xy[rows]
    gaps = xy[:, None, :] - xy[None, :, :]
    travel = np.sqrt((gaps**2).sum(axis=2))
    service = instance.service[rows].astype(float)
    early, late = instance.early[rows].astype(float), instance.late[rows].astype(float)
    direct = travel[np.arange(0, n, 2), np.arange(1, n, 2)]
    out, back = travel[n, :n], late[n] - travel[:n, n] - service[:n]
    early[:n], late[:n] = tightened(
        early[:n], late[:n], service[:n], direct, np.full(n // 2, instance.ride_max), early[n] + out, back
    )
    ride_s_max = np.full(len(rows), np.inf)
    ride_s_max[0:n:2] = instance.ride_max
    ride_s_max[n::2] = instance.duration_max
    load = np.zeros((len(rows), LOAD_KINDS), np.int32)
    load[:, 0] = instance.load[rows]
    capacity = np.zeros((vehicles, LOAD_KINDS), np.int32)
    capacity[:, 0] = instance.capacity
    dearest = 4.0 * float(travel.max()) if n else 1.0
    cost = dearest if absent_cost is None else absent_cost
    return Task(
        place=np.arange(len(rows), dtype=np.int32),
        early_s=early,
        late_s=late,
        service_s=service,
        load=load,
        ride_s_max=ride_s_max,
        delay_cost=np.zeros(len(rows)),
        capacity=capacity,
        kind=np.zeros(vehicles, np.int32),
        drive_s_max=np.full(vehicles, np.inf),
        vehicle_cost=np.zeros(vehicles),
        absent_cost=np.full(n // 2, cost),
        travel_s=travel,
        xy=np.zeros((0, 2)),
        slowness=1.0,
        joined=False,
        travel_time_factor=np.ones(len(rows)),
        plain=bool(np.isinf(instance.ride_max) and np.isinf(instance.duration_max)),
    )


def node_routes(instance: Instance, plan: Plan) -> list[list[int]]:
    """For each vehicle the node numbers of its visits in order, the depot left out."""
    pairs = np.ravel(instance.pairs)
    return [
        [int(instance.nodes[pairs[node]]) for node in route[1 : length - 1]]
        for route, length in zip(plan.route, plan.length, strict=True)
    ]


def unserved(plan: Plan) -> AnyArray:
    """Requests in no route."""
    return np.flatnonzero(plan.vehicle_of < 0)
