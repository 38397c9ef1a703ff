"""Routes under construction: rows of nodes with their times, loads and cost."""

from typing import NamedTuple

import numpy as np
from numba import uint64

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.task import LOAD_KINDS, Task, drive_s
from server.dispatch.engine.timing import greatest_times, least_times

ABSENT = -1
# A vehicle's start is behind it.
_START_LOCKED = 1
# Insertions into one route that may be waiting for their exact check.
_CANDIDATES = 500
_STAMP_BASE = np.uint64(0x9E3779B97F4A7C15)
_STAMP_SHIFT = np.uint64(29)


class Plan(NamedTuple):
    """Arrays over V vehicles with room for M visits each, R requests and N nodes.

    route       (V, M) int32 nodes in driving order, the vehicle's start first and its end last
    length      (V,) how many of them there are
    locked      (V,) so many leading nodes stay as they are, the start at least
    least_s, most_s   (V, M) earliest and latest beginning of each visit
    load        (V, M, 2) occupied after each visit
    driven_s    (V,)
    cost        (V,)
    vehicle_of  (R,) ABSENT for a request in no route
    slot        (N,) position in its route of each node that is in one
    movable     (R,) bool: its pickup is still ahead, so that another vehicle may do it
    stamp       (V,) uint64 tells rows apart: equal rows of a vehicle have equal stamps, others have not
    """

    route: AnyArray
    length: AnyArray
    locked: AnyArray
    least_s: AnyArray
    most_s: AnyArray
    load: AnyArray
    driven_s: AnyArray
    cost: AnyArray
    vehicle_of: AnyArray
    slot: AnyArray
    movable: AnyArray
    stamp: AnyArray


class Scratch(NamedTuple):
    """Room for trying out one route; nothing in it outlives a call. Arrays (M,), where (N,).

    extra, pair   (C,), (C, 2) candidates for an insertion: least extra cost and positions
    """

    nodes: AnyArray
    at_s: AnyArray
    leg_s: AnyArray
    elapsed_s: AnyArray
    where: AnyArray
    extra: AnyArray
    pair: AnyArray


def empty_plan(task: Task, room: int) -> Plan:
    """Vehicles that go from their starts to their ends, every request absent.

    room  the longest route in visits, start and end included
    """
    vehicles, nodes = task.vehicles, len(task.place)
    plan = Plan(
        route=np.zeros((vehicles, room), np.int32),
        length=np.full(vehicles, 2, np.int32),
        locked=np.full(vehicles, _START_LOCKED, np.int32),
        least_s=np.zeros((vehicles, room)),
        most_s=np.zeros((vehicles, room)),
        load=np.zeros((vehicles, room, LOAD_KINDS), np.int32),
        driven_s=np.zeros(vehicles),
        cost=np.zeros(vehicles),
        vehicle_of=np.full(task.requests, ABSENT, np.int32),
        slot=np.zeros(nodes, np.int32),
        movable=np.ones(task.requests, np.bool_),
        stamp=np.zeros(vehicles, np.uint64),
    )
    starts = 2 * (task.requests + np.arange(vehicles))
    plan.route[:, 0], plan.route[:, 1] = starts, starts + 1
    return plan


def scratch_for(task: Task, room: int) -> Scratch:
    return Scratch(
        nodes=np.zeros(room, np.int32),
        at_s=np.zeros(room),
        leg_s=np.zeros(room),
        elapsed_s=np.zeros(room),
        where=np.zeros(len(task.place), np.int32),
        extra=np.zeros(_CANDIDATES + room),
        pair=np.zeros((_CANDIDATES + room, 2), np.int32),
    )


@kernel
def refresh(task: Task, plan: Plan, scratch: Scratch, v: int) -> bool:
    """Times, loads and cost of a route that was changed; whether it keeps every rule."""
    n = plan.length[v]
    nodes, least = plan.route[v], plan.least_s[v]
    for k in range(1, n):
        least[k] = -np.inf
    least[0] = task.early_s[nodes[0]]
    if not least_times(task, nodes, n, 1, least, scratch.leg_s, scratch.elapsed_s, plan.slot):
        return False
    greatest_times(task, nodes, n, plan.most_s[v], scratch.leg_s, plan.slot)
    driven, cost = 0.0, 0.0
    stamp = uint64(plan.locked[v])
    load = plan.load[v]
    for kind in range(LOAD_KINDS):
        load[0, kind] = task.load[nodes[0], kind]
    for k in range(1, n):
        b = nodes[k]
        driven += drive_s(task, nodes[k - 1], b)
        stamp = (stamp ^ (stamp >> _STAMP_SHIFT)) * _STAMP_BASE + uint64(nodes[k - 1])
        cost += task.delay_cost[b] * (least[k] - task.early_s[b])
        for kind in range(LOAD_KINDS):
            load[k, kind] = load[k - 1, kind] + task.load[b, kind]
            if load[k, kind] > task.capacity[v, kind]:
                return False
    plan.stamp[v] = (stamp ^ (stamp >> _STAMP_SHIFT)) * _STAMP_BASE
    plan.driven_s[v] = driven
    plan.cost[v] = driven + cost + (task.vehicle_cost[v] if n > _START_LOCKED + 1 else 0.0)
    return bool(driven <= task.drive_s_max[v])


@kernel
def copy_route(plan: Plan, other: Plan, v: int) -> None:
    """Take one vehicle's row over from another plan of the same task. Requests are not touched."""
    n = other.length[v]
    plan.length[v] = n
    plan.stamp[v] = other.stamp[v]
    plan.locked[v] = other.locked[v]
    plan.driven_s[v] = other.driven_s[v]
    plan.cost[v] = other.cost[v]
    for k in range(n):
        node = other.route[v, k]
        plan.route[v, k] = node
        plan.slot[node] = k
        plan.least_s[v, k] = other.least_s[v, k]
        plan.most_s[v, k] = other.most_s[v, k]
        for kind in range(LOAD_KINDS):
            plan.load[v, k, kind] = other.load[v, k, kind]


@kernel
def copy_plan(plan: Plan, other: Plan) -> None:
    """Make a plan the same as another one of the same task."""
    for v in range(len(plan.length)):
        copy_route(plan, other, v)
    for r in range(len(plan.vehicle_of)):
        plan.vehicle_of[r] = other.vehicle_of[r]
        plan.movable[r] = other.movable[r]


@kernel
def total_cost(task: Task, plan: Plan) -> float:
    cost = 0.0
    for v in range(len(plan.cost)):
        cost += plan.cost[v]
    for r in range(len(plan.vehicle_of)):
        if plan.vehicle_of[r] == ABSENT:
            cost += task.absent_cost[r]
    return float(cost)
