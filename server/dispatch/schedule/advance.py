"""Moves the fleet on in time: vehicles set out for their visits and complete them."""

from typing import NamedTuple

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.plan import Plan, Scratch, refresh
from server.dispatch.engine.task import LOAD_KINDS, Task, drive_s

_START_LOCKED = 1
_UNDER_WAY = 2


class CompletedCalls(NamedTuple):
    """Visits made: vehicle, node, at_s (n,) when each began.

    used (2,): rows in use, and routes that turned out to break a rule.
    """

    vehicle: AnyArray
    node: AnyArray
    at_s: AnyArray
    used: AnyArray


def made_log(room: int) -> CompletedCalls:
    return CompletedCalls(
        np.zeros(room, np.int32), np.zeros(room, np.int32), np.zeros(room), np.zeros(2, np.int64)
    )


@kernel
def advance(
    task: Task, plan: Plan, scratch: Scratch, now_s: float, departure_slack: float, made: CompletedCalls
) -> float:
    """Move every vehicle on to `now_s` along its route, and record the visits made. Returns the seconds of
    the legs that were begun.

    A leg is begun so that its visit begins between its earliest (slack 0) and its latest time (1). A
    vehicle that waits can still be sent elsewhere; one that left early has time in hand. A vehicle's start
    then stands for where it was last, and for the time at which it is free there.
    """
    made.used[0] = made.used[1] = 0
    driven_s = 0.0
    for v in range(len(plan.length)):
        start = plan.route[v, 0]
        while plan.length[v] > 2:
            node = plan.route[v, 1]
            if plan.locked[v] < _UNDER_WAY:
                leg_s = drive_s(task, start, node)
                least_s = plan.least_s[v, 1]
                begins_s = least_s + departure_slack * max(0.0, plan.most_s[v, 1] - least_s)
                if begins_s - leg_s > now_s:
                    break
                _set_out(task, plan, v, begins_s, leg_s)
                made.used[1] += not refresh(task, plan, scratch, v)
                driven_s += leg_s
            if plan.least_s[v, 1] + task.service_s[node] > now_s:
                break
            k = made.used[0]
            made.vehicle[k], made.node[k], made.at_s[k] = v, node, plan.least_s[v, 1]
            made.used[0] = k + 1
            _leave_behind(task, plan, v)
            made.used[1] += not refresh(task, plan, scratch, v)
        if plan.locked[v] < _UNDER_WAY and task.early_s[start] < now_s:
            task.early_s[start] = now_s
            plan.least_s[v, 0] = now_s
            if plan.length[v] > 2 and now_s + drive_s(task, start, plan.route[v, 1]) > plan.least_s[v, 1]:
                made.used[1] += not refresh(task, plan, scratch, v)
    return driven_s


@kernel
def _set_out(task: Task, plan: Plan, v: int, begins_s: float, leg_s: float) -> None:
    """Fix the next visit at its planned time; the duty has begun."""
    start, node = plan.route[v, 0], plan.route[v, 1]
    plan.locked[v] = _UNDER_WAY
    task.early_s[node] = task.late_s[node] = begins_s
    if node < 2 * len(plan.vehicle_of):
        plan.movable[node >> 1] = False
    if task.ride_s_max[start] < np.inf:
        task.late_s[start + 1] = min(task.late_s[start + 1], begins_s - leg_s + task.ride_s_max[start])
        task.ride_s_max[start] = np.inf


@kernel
def _leave_behind(task: Task, plan: Plan, v: int) -> None:
    """The vehicle is free at its last visit. The longest ride of a new rider ends at a fixed time now."""
    start, node, following = plan.route[v, 0], plan.route[v, 1], plan.route[v, 2]
    free_s = plan.least_s[v, 1] + task.service_s[node]
    task.early_s[start] = free_s
    if task.joined and task.place[following] == task.place[node]:
        # Riders board and alight at the same time: the next ones have begun already.
        task.early_s[start] = min(free_s, plan.least_s[v, 2])
    for kind in range(LOAD_KINDS):
        task.load[start, kind] += task.load[node, kind]
    here, there = task.place[start], task.place[node]
    if task.travel_s.shape[0] > 0:
        for place in range(task.travel_s.shape[1]):
            task.travel_s[here, place] = task.travel_s[there, place]
    else:
        task.xy[here, 0], task.xy[here, 1] = task.xy[there, 0], task.xy[there, 1]
    if node < 2 * len(plan.vehicle_of) and node & 1 == 0:
        task.late_s[node + 1] = min(task.late_s[node + 1], free_s + task.ride_s_max[node])
        task.ride_s_max[node] = np.inf
    n = plan.length[v]
    for k in range(1, n - 1):
        plan.route[v, k] = plan.route[v, k + 1]
    plan.length[v] = n - 1
    plan.locked[v] = _START_LOCKED
    plan.least_s[v, 0] = task.early_s[start]
