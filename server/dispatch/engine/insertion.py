"""Where a request fits into a route, and its cost there.

For each pair of positions a few comparisons with the route's earliest and latest times and its loads settle
nearly every case. Of the remaining pairs, the cheapest is timed exactly, then the next one, until one passes.
So a test takes constant time, amortised (the idea of Savelsbergh 1992 and Gschwind and Drexl 2019; the exact
check is ours).
"""

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import inlined, kernel
from server.dispatch.engine.draw import uniform
from server.dispatch.engine.plan import Plan, Scratch, refresh
from server.dispatch.engine.task import EPSILON_S, LOAD_KINDS, Task, drive_s, stand_s
from server.dispatch.engine.timing import least_times

# Numba compiles a callee once more for each constant that a variable of its caller begins with; `int(...)`
# makes the type the one that it has later.
_NOWHERE, _NONE_YET = -1, 0


@kernel
def _fits(load: AnyArray, more: AnyArray, capacity: AnyArray) -> bool:
    for kind in range(LOAD_KINDS):  # noqa: SIM110 - compiled: a loop, not a generator
        if load[kind] + more[kind] > capacity[kind]:
            return False
    return True


@inlined
def _exact_cost(task: Task, plan: Plan, scratch: Scratch, v: int, r: int, i: int, j: int) -> float:
    n = plan.length[v]
    nodes, at_s = scratch.nodes, scratch.at_s
    route, least = plan.route[v], plan.least_s[v]
    for k in range(i + 1):
        nodes[k] = route[k]
        at_s[k] = least[k]
    nodes[i + 1] = 2 * r
    at_s[i + 1] = -np.inf
    for k in range(i + 1, j + 1):
        nodes[k + 1] = route[k]
        at_s[k + 1] = least[k]
    nodes[j + 2] = 2 * r + 1
    at_s[j + 2] = -np.inf
    for k in range(j + 1, n):
        nodes[k + 2] = route[k]
        at_s[k + 2] = least[k]
    if not least_times(task, nodes, n + 2, i + 1, at_s, scratch.leg_s, scratch.elapsed_s, scratch.where):
        return np.inf
    driven, cost = 0.0, task.vehicle_cost[v]
    for k in range(1, n + 2):
        b = nodes[k]
        driven += drive_s(task, nodes[k - 1], b)
        if task.delay_cost[b] != 0.0:
            cost += task.delay_cost[b] * (at_s[k] - task.early_s[b])
    return driven + cost if driven <= task.drive_s_max[v] else np.inf


@kernel
def exact_cost(task: Task, plan: Plan, scratch: Scratch, v: int, r: int, i: int, j: int) -> float:
    """Cost of route v with r's pickup after position i and its drop-off after j (both as they are now); inf
    where a rule breaks."""
    return _exact_cost(task, plan, scratch, v, r, i, j)


@kernel
def times_at(task: Task, plan: Plan, scratch: Scratch, v: int, r: int, i: int, j: int) -> tuple[float, float]:
    """When r would be picked up and set down at a place that `best_place` has found."""
    _exact_cost(task, plan, scratch, v, r, i, j)
    return scratch.at_s[i + 1], scratch.at_s[j + 2]


@inlined
def _listed(scratch: Scratch, candidates: int, extra: float, i: int, j: int) -> int:
    """List a place whose times are still to be checked exactly; the number of candidates after it."""
    scratch.extra[candidates] = extra
    scratch.pair[candidates, 0], scratch.pair[candidates, 1] = i, j
    return candidates + 1


@kernel
def best_place(
    task: Task, plan: Plan, scratch: Scratch, v: int, r: int, below: float, blink: float, rng: AnyArray
) -> tuple[float, int, int]:
    """(extra cost, i, j) of the cheapest way to serve r with vehicle v: pickup after position i, drop-off
    after j. Only what costs less than `below` counts; (inf, 0, 0) where nothing does.

    blink   chance to overlook a place that would be the best so far (Christiaens and Vanden Berghe 2020)
    """
    p, d, n = 2 * r, 2 * r + 1, plan.length[v]
    # A route that became infeasible when a visit was taken out has no times for an insertion.
    if n + 2 > plan.route.shape[1] or plan.cost[v] == np.inf:
        return np.inf, 0, 0
    route, least, most, load = plan.route[v], plan.least_s[v], plan.most_s[v], plan.load[v]
    capacity, more = task.capacity[v], task.load[p]
    best, best_i, best_j = below, int(_NOWHERE), int(_NOWHERE)
    candidates = int(_NONE_YET)
    opening = task.vehicle_cost[v] if n == 2 else 0.0
    ride_max = task.ride_s_max[p] + task.service_s[p]
    p_to_d = drive_s(task, p, d)
    for i in range(plan.locked[v] - 1, n - 1):
        if candidates > len(scratch.extra) - n:
            settled = _settled(task, plan, scratch, v, r, candidates, best, best_i, best_j, blink, rng)
            best, best_i, best_j = settled
            if best == np.inf:
                best, best_i = below, int(_NOWHERE)
            candidates = int(_NONE_YET)
        # Most positions are hours away: the times alone reject them.
        if most[i + 1] < task.early_s[p]:
            continue
        if least[i] > task.late_s[p]:
            break
        a, b = route[i], route[i + 1]
        at_p = max(task.early_s[p], least[i] + stand_s(task, a, p) + drive_s(task, a, p))
        if at_p > task.late_s[p] + EPSILON_S:
            if task.has_travel_time_factors:
                continue
            break
        if not _fits(load[i], more, capacity):
            continue
        to_p = drive_s(task, a, p)
        skipped = drive_s(task, a, b)
        waited = opening + task.delay_cost[p] * (at_p - task.early_s[p])
        p_to_b = drive_s(task, p, b)
        latest_p = min(task.late_s[p], most[i + 1] - stand_s(task, p, b) - p_to_b)
        # Straight on to the drop-off.
        d_to_b = drive_s(task, d, b)
        at_d = max(task.early_s[d], at_p + stand_s(task, p, d) + p_to_d)
        extra = waited + to_p + p_to_d + d_to_b - skipped + task.delay_cost[d] * (at_d - task.early_s[d])
        if (
            extra < best
            and at_d <= task.late_s[d] + EPSILON_S
            and at_d + stand_s(task, d, b) + d_to_b <= most[i + 1] + EPSILON_S
        ):
            if not task.plain:
                candidates = _listed(scratch, candidates, extra, i, i)
            elif blink == 0.0 or uniform(rng) >= blink:
                best, best_i, best_j = extra, i, i
        # With others in between.
        at = at_p + stand_s(task, p, b) + p_to_b
        detour = waited + to_p + p_to_b - skipped
        if at > most[i + 1] + EPSILON_S or (detour >= best and not task.has_travel_time_factors):
            continue
        for j in range(i + 1, n - 1):
            at = max(at, least[j])
            a, b = route[j], route[j + 1]
            if at > most[j] + EPSILON_S or not _fits(load[j], more, capacity):
                break
            to_d = drive_s(task, a, d)
            at_d = max(task.early_s[d], at + stand_s(task, a, d) + to_d)
            d_to_b, a_to_b = drive_s(task, d, b), drive_s(task, a, b)
            if at_d > task.late_s[d] + EPSILON_S or at_d - latest_p > ride_max + EPSILON_S:
                if task.has_travel_time_factors:
                    at += stand_s(task, a, b) + a_to_b
                    continue
                break
            extra = detour + to_d + d_to_b - a_to_b + task.delay_cost[d] * (at_d - task.early_s[d])
            if extra < best and at_d + stand_s(task, d, b) + d_to_b <= most[j + 1] + EPSILON_S:
                if not task.plain:
                    candidates = _listed(scratch, candidates, extra, i, j)
                elif blink == 0.0 or uniform(rng) >= blink:
                    best, best_i, best_j = extra, i, j
            at += stand_s(task, a, b) + a_to_b
    if candidates == 0:
        return (best, best_i, best_j) if best_i >= 0 else (np.inf, 0, 0)
    return _settled(task, plan, scratch, v, r, candidates, best, best_i, best_j, blink, rng)


@kernel
def _settled(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    v: int,
    r: int,
    candidates: int,
    best: float,
    best_i: int,
    best_j: int,
    blink: float,
    rng: AnyArray,
) -> tuple[float, int, int]:
    """The cheapest of the candidates that the exact check lets pass, or else what was the best before; cost
    is inf where there is none."""
    while True:
        least_extra, which = best, -1
        for k in range(candidates):
            if scratch.extra[k] < least_extra:
                least_extra, which = scratch.extra[k], k
        if which < 0:
            break
        i, j = scratch.pair[which, 0], scratch.pair[which, 1]
        scratch.extra[which] = np.inf
        cost = _exact_cost(task, plan, scratch, v, r, i, j) - plan.cost[v]
        if cost < best and (blink == 0.0 or uniform(rng) >= blink):
            best, best_i, best_j = cost, i, j
    if best_i < 0:
        return np.inf, 0, 0
    return best, best_i, best_j


@kernel
def insert(task: Task, plan: Plan, scratch: Scratch, v: int, r: int, i: int, j: int) -> None:
    """Put r into route v at a place that `best_place` has found."""
    n = plan.length[v]
    route = plan.route[v]
    for k in range(n - 1, j, -1):
        route[k + 2] = route[k]
    route[j + 2] = 2 * r + 1
    for k in range(j, i, -1):
        route[k + 1] = route[k]
    route[i + 1] = 2 * r
    plan.length[v] = n + 2
    plan.vehicle_of[r] = v
    refresh(task, plan, scratch, v)
