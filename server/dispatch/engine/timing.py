"""Exact times of a route: the least and the greatest solution of its difference constraints.

Every rule bounds one visit's beginning by another's: driving and dwell from the one before, windows by fixed
numbers, the longest ride between partners. Forward passes raise the times until nothing moves; what they
end in
is the earliest schedule there is (Bellman 1958). Backward passes give the latest. A further visit can only
shrink the room between the two, which is what makes the insertion test cheap.
"""

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.task import EPSILON_S, Task, drive_s, stand_s


@kernel
def least_times(
    task: Task,
    nodes: AnyArray,
    n: int,
    first: int,
    at_s: AnyArray,
    leg_s: AnyArray,
    elapsed_s: AnyArray,
    where: AnyArray,
) -> bool:
    """Whether a route keeps all windows and rides; if so `at_s` holds the earliest beginning of each visit.

    nodes   (n,) of the route, start and end included
    at_s    (n,) in: lower bounds of the beginnings, those before `first` being exact for what is before them
    leg_s, elapsed_s, where   scratch: (n,), (n,), (nodes of the task,)
    """
    where[nodes[0]] = 0
    elapsed_s[0] = 0.0
    for k in range(1, n):
        a, b = nodes[k - 1], nodes[k]
        leg = stand_s(task, a, b) + drive_s(task, a, b)
        leg_s[k] = leg
        elapsed_s[k] = elapsed_s[k - 1] + leg
        where[b] = k
        if k >= first:
            begin = max(at_s[k], task.early_s[b], at_s[k - 1] + leg)
            if begin > task.late_s[b] + EPSILON_S:
                return False
            at_s[k] = begin
        if b & 1 and task.ride_s_max[b - 1] < np.inf:
            # However long it waits before: from pickup to drop-off it takes no less than this.
            q = where[b - 1]
            if elapsed_s[k] - elapsed_s[q] - task.service_s[b - 1] > task.ride_s_max[b - 1] + EPSILON_S:
                return False
    for _ in range(n):
        moved = n
        for k in range(1, n):
            b = nodes[k]
            if b & 1 and task.ride_s_max[b - 1] < np.inf:
                q = where[b - 1]
                needed = at_s[k] - task.ride_s_max[b - 1] - task.service_s[b - 1]
                if needed > at_s[q] + EPSILON_S:
                    if needed > task.late_s[b - 1] + EPSILON_S:
                        return False
                    at_s[q] = needed
                    moved = min(moved, q)
        if moved == n:
            return True
        for k in range(moved + 1, n):
            begin = max(at_s[k], at_s[k - 1] + leg_s[k])
            if begin > task.late_s[nodes[k]] + EPSILON_S:
                return False
            at_s[k] = begin
    return False


@kernel
def greatest_times(task: Task, nodes: AnyArray, n: int, at_s: AnyArray, where: AnyArray) -> None:
    """Fill `at_s` (n,) with the latest beginnings of a route that `least_times` has found feasible.

    where   position of each of the route's nodes
    """
    for k in range(n):
        at_s[k] = task.late_s[nodes[k]]
    for _ in range(n + 1):
        moved = False
        for k in range(n - 2, -1, -1):
            a, b = nodes[k], nodes[k + 1]
            latest = at_s[k + 1] - stand_s(task, a, b) - drive_s(task, a, b)
            if latest < at_s[k]:
                at_s[k] = latest
        for k in range(1, n):
            b = nodes[k]
            if b & 1 and task.ride_s_max[b - 1] < np.inf:
                latest = at_s[where[b - 1]] + task.service_s[b - 1] + task.ride_s_max[b - 1]
                if latest < at_s[k] - EPSILON_S:
                    at_s[k] = latest
                    moved = True
        if not moved:
            return
