"""Extends windows that the present route misses to what it still reaches. A late ride is not made later."""

import numpy as np
from numba import njit

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.plan import Plan, Scratch
from server.dispatch.engine.task import EPSILON_S, Task, drive_s, stand_s

# Room for rounding.
_ROOM_S = 1e-3


def settle(task: Task, plan: Plan, scratch: Scratch, v: int) -> list[int]:
    """Extend the windows, rides, duty and battery of a route as far as it misses them. Returns the late
    nodes.

    The task's arrays change. Seats are not extended.
    """
    n = int(plan.length[v])
    late = _settle(task, plan.route[v], n, scratch.at_s, scratch.where)
    driven_s = sum(float(drive_s(task, plan.route[v, k - 1], plan.route[v, k])) for k in range(1, n))
    task.drive_s_max[v] = max(task.drive_s_max[v], driven_s)
    return [int(node) for node in late]


@njit(cache=True)
def _settle(task: Task, nodes: AnyArray, n: int, at_s: AnyArray, where: AnyArray) -> AnyArray:
    """Drive as early as possible without regard to deadlines. What is late then cannot be in time."""
    late = np.zeros(n, np.bool_)
    at_s[0] = task.early_s[nodes[0]]
    where[nodes[0]] = 0
    for k in range(1, n):
        a, b = nodes[k - 1], nodes[k]
        at_s[k] = max(task.early_s[b], at_s[k - 1] + stand_s(task, a, b) + drive_s(task, a, b))
        where[b] = k
        if at_s[k] > task.late_s[b] + EPSILON_S:
            task.late_s[b] = at_s[k] + _ROOM_S
            late[k] = True
        if b & 1 and task.ride_s_max[b - 1] < np.inf:
            ride_s = at_s[k] - at_s[where[b - 1]] - task.service_s[b - 1]
            if ride_s > task.ride_s_max[b - 1] + EPSILON_S:
                task.ride_s_max[b - 1] = ride_s + _ROOM_S
                late[k] = True
    return nodes[:n][late]
