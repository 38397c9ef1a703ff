"""Inserts a timetable departure: its calls in order, in one vehicle, with other calls allowed between
them."""

import numpy as np
from numba import njit

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.plan import Plan, Scratch, refresh
from server.dispatch.engine.task import Task, drive_s
from server.dispatch.engine.timing import least_times
from server.dispatch.problem import Chain
from server.dispatch.schedule.schedule import Schedule


def insert_chain(schedule: Schedule, chain: Chain) -> bool:
    """Give the departure to the vehicle that makes it at the least cost. Returns whether one can.

    Every position of the first call is tried; each further call takes the cheapest one after it.
    """
    nodes = np.array([schedule.add_fixed(call) for call in chain.calls], dtype=np.int32)
    best, best_v, best_at = np.inf, -1, np.zeros(0, np.int64)
    for v in range(len(schedule.vehicle_ids)):
        if schedule.accepts[v]:
            cost, at = _cheapest_chain(schedule.task, schedule.plan, schedule.scratch, v, nodes, best)
            if cost < best:
                best, best_v, best_at = float(cost), v, at
    if best_v < 0:
        return False
    _put(schedule.plan, best_v, nodes, best_at)
    refresh(schedule.task, schedule.plan, schedule.scratch, best_v)
    return True


@njit(cache=True)
def _cheapest_chain(
    task: Task, plan: Plan, scratch: Scratch, v: int, chain: AnyArray, below: float
) -> tuple[float, AnyArray]:
    """Extra cost, and the position of each call in the route as it is once that call is in."""
    n, calls = plan.length[v], len(chain)
    best_at = np.zeros(calls, np.int64)
    at = np.zeros(calls, np.int64)
    route = np.zeros(n + calls, np.int32)
    trial = np.zeros(n + calls, np.int32)
    best = below
    if n + calls > plan.route.shape[1]:
        return np.inf, best_at
    for first in range(plan.locked[v], n):
        route[:n] = plan.route[v, :n]
        cost = np.inf
        for c in range(calls):
            lowest, highest = (first, first) if c == 0 else (at[c - 1] + 1, n + c - 1)
            cost, chosen = np.inf, -1
            for position in range(lowest, highest + 1):
                trial[:position] = route[:position]
                trial[position] = chain[c]
                trial[position + 1 : n + c + 1] = route[position : n + c]
                found = _cost(task, scratch, trial, n + c + 1, v)
                if found < cost:
                    cost, chosen = found, position
            if chosen < 0:
                break
            at[c] = chosen
            route[chosen + 1 : n + c + 1] = route[chosen : n + c].copy()
            route[chosen] = chain[c]
        if cost - plan.cost[v] < best:
            best = cost - plan.cost[v]
            best_at[:] = at
    return (best if best < below else np.inf), best_at


@njit(cache=True)
def _cost(task: Task, scratch: Scratch, nodes: AnyArray, n: int, v: int) -> float:
    """Cost of a route whose loads are known to fit; inf where it breaks a rule."""
    at_s = scratch.at_s
    at_s[:n] = -np.inf
    at_s[0] = task.early_s[nodes[0]]
    if not least_times(task, nodes, n, 1, at_s, scratch.leg_s, scratch.elapsed_s, scratch.where):
        return np.inf
    driven, cost = 0.0, task.vehicle_cost[v]
    for k in range(1, n):
        driven += drive_s(task, nodes[k - 1], nodes[k])
        cost += task.delay_cost[nodes[k]] * (at_s[k] - task.early_s[nodes[k]])
    return driven + cost if driven <= task.drive_s_max[v] else np.inf


def _put(plan: Plan, v: int, nodes: AnyArray, at: AnyArray) -> None:
    for node, position in zip(nodes, at, strict=True):
        n = plan.length[v]
        plan.route[v, position + 1 : n + 1] = plan.route[v, position:n].copy()
        plan.route[v, position] = node
        plan.length[v] = n + 1
