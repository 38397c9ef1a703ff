"""Exact times of a route: the least and the greatest solution of its difference constraints.

Every rule bounds one visit's beginning by another's: driving and dwell from the one before, windows by fixed
numbers, the longest ride between partners. Forward passes raise the times until nothing moves; the result is
the earliest schedule (Bellman 1958). Backward passes give the latest one. A further visit can only shrink the
room between the two, which makes the insertion test cheap.
"""

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import inlined
from server.dispatch.engine.task import EPSILON_S, Task, drive_s, stand_s


@inlined
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
    leg_s, elapsed_s, where   scratch: (n,), (n,), (nodes of the task,); leg_s[k] is from visit k - 1 to k
    """
    where[nodes[0]] = 0
    elapsed_s[0] = 0.0
    # The first visit that must begin later because of a longest ride; n for none.
    moved = n
    for k in range(1, n):
        a, b = nodes[k - 1], nodes[k]
        leg = stand_s(task, a, b) + drive_s(task, a, b)
        leg_s[k] = leg
        elapsed_s[k] = elapsed_s[k - 1] + leg
        where[b] = k
        begin = at_s[k]
        if k >= first:
            begin = max(begin, task.early_s[b], at_s[k - 1] + leg)
            if begin > task.late_s[b] + EPSILON_S:
                return False
            at_s[k] = begin
        if b & 1 and task.ride_s_max[b - 1] < np.inf:
            q = where[b - 1]
            longest = task.ride_s_max[b - 1] + task.service_s[b - 1]
            # Waiting before the pickup cannot make the ride shorter than this.
            if elapsed_s[k] - elapsed_s[q] > longest + EPSILON_S:
                return False
            needed = begin - longest
            if needed > at_s[q] + EPSILON_S:
                if needed > task.late_s[b - 1] + EPSILON_S:
                    return False
                at_s[q] = needed
                moved = min(moved, q)
    for _ in range(n):
        if moved == n:
            return True
        start, moved = moved, n
        for k in range(start + 1, n):
            b = nodes[k]
            begin = at_s[k - 1] + leg_s[k]
            if begin > at_s[k]:
                if begin > task.late_s[b] + EPSILON_S:
                    return False
                at_s[k] = begin
            else:
                begin = at_s[k]
            if b & 1 and task.ride_s_max[b - 1] < np.inf:
                q = where[b - 1]
                needed = begin - task.ride_s_max[b - 1] - task.service_s[b - 1]
                if needed > at_s[q] + EPSILON_S:
                    if needed > task.late_s[b - 1] + EPSILON_S:
                        return False
                    at_s[q] = needed
                    moved = min(moved, q)
    return False


@inlined
def greatest_times(
    task: Task, nodes: AnyArray, n: int, at_s: AnyArray, leg_s: AnyArray, where: AnyArray
) -> None:
    """Fill `at_s` (n,) with the latest beginnings of a route that `least_times` has found feasible.

    leg_s, where   as `least_times` has left them
    """
    for k in range(n):
        at_s[k] = task.late_s[nodes[k]]
    # The last visit that must begin earlier because of a longest ride; -1 for none.
    moved = n - 1
    for _ in range(n + 1):
        start, moved = moved, -1
        for k in range(start, -1, -1):
            if k < n - 1:
                at_s[k] = min(at_s[k], at_s[k + 1] - leg_s[k + 1])
            a = nodes[k]
            if a & 1 == 0 and task.ride_s_max[a] < np.inf:
                q = where[a + 1]
                latest = at_s[k] + task.service_s[a] + task.ride_s_max[a]
                if latest < at_s[q] - EPSILON_S:
                    at_s[q] = latest
                    moved = max(moved, q)
        if moved < 0:
            return
