"""Which requests are near each other in space and time, so that exchanging them can pay."""

import numpy as np
from numba import njit

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.task import Task, drive_s, stand_s

# A second of waiting between two visits sets them apart less than a second of driving.
_WAITING = 0.2


def near_requests(task: Task, neighbours: int) -> AnyArray:
    """(R, K) int32: for each request those nearest to it, itself first; K is at most `neighbours`."""
    apart = _apart(task)
    k = min(neighbours, task.requests)
    return np.argsort(apart, axis=1, kind="stable")[:, :k].astype(np.int32)


@njit(cache=True)
def _apart(task: Task) -> AnyArray:
    requests = len(task.absent_cost)
    apart = np.zeros((requests, requests))
    for r in range(requests):
        apart[r, r] = -1.0
        for other in range(r):
            least = np.inf
            for a in range(2 * r, 2 * r + 2):
                for b in range(2 * other, 2 * other + 2):
                    least = min(least, _after(task, a, b), _after(task, b, a))
            apart[r, other] = apart[other, r] = least
    return apart


@njit(cache=True)
def _after(task: Task, a: int, b: int) -> float:
    """The cost of visiting b right after a: driving and some of the waiting; inf if it is too late."""
    leg = stand_s(task, a, b) + drive_s(task, a, b)
    if task.early_s[a] + leg > task.late_s[b]:
        return np.inf
    return float(drive_s(task, a, b) + _WAITING * max(0.0, task.early_s[b] - task.late_s[a] - leg))
