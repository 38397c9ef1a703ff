"""Takes requests out of a plan: strings of neighbouring visits from neighbouring routes.

Slack induction by string removals (Christiaens and Vanden Berghe 2020, section 5): room is made where several
routes come close to each other, so that their parts can be exchanged.
"""

from typing import NamedTuple

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import inlined, kernel
from server.dispatch.engine.draw import below, uniform
from server.dispatch.engine.plan import ABSENT, Plan, Scratch, copy_route, refresh
from server.dispatch.engine.task import Task

# Chance that some visits in the middle of a string stay, and that one more of them stays (section 5.2).
_SPLIT = 0.5
_SPLIT_LONGER = 0.5


class Undo(NamedTuple):
    """What is needed to take an attempt back.

    before      a plan holding the touched rows as they were
    touched     (V,) bool; touched_list (V,) and counts[0] of them
    absent      (R,) and counts[1] of them: requests taken out or in no route before
    home        (R,) the vehicle each of them had, ABSENT for none
    order, key  (R,) the positions in `absent` as they are put back, and what they are sorted by
    """

    before: Plan
    touched: AnyArray
    touched_list: AnyArray
    absent: AnyArray
    home: AnyArray
    counts: AnyArray
    order: AnyArray
    key: AnyArray


def undo_for(before: Plan) -> Undo:
    vehicles, requests = len(before.length), len(before.vehicle_of)
    return Undo(
        before=before,
        touched=np.zeros(vehicles, np.bool_),
        # Vehicles and requests are 64-bit numbers wherever a kernel takes one, so that it is compiled once.
        touched_list=np.zeros(vehicles, np.int64),
        absent=np.zeros(requests, np.int64),
        home=np.zeros(requests, np.int32),
        counts=np.zeros(2, np.int64),
        order=np.zeros(requests, np.int32),
        key=np.zeros(requests),
    )


@inlined
def touch(plan: Plan, undo: Undo, v: int) -> None:
    """Keep the row as it is now, once an attempt."""
    if not undo.touched[v]:
        copy_route(undo.before, plan, v)
        undo.touched[v] = True
        undo.touched_list[undo.counts[0]] = v
        undo.counts[0] += 1


@inlined
def take_out(plan: Plan, undo: Undo, r: int) -> None:
    """Mark a request as absent; its visits leave the row with `close_gaps`."""
    k = undo.counts[1]
    undo.absent[k] = r
    undo.home[k] = plan.vehicle_of[r]
    undo.counts[1] = k + 1
    plan.vehicle_of[r] = ABSENT


@inlined
def close_gaps(task: Task, plan: Plan, scratch: Scratch, v: int) -> None:
    """Drop the visits of requests that are no longer this vehicle's."""
    requests = len(plan.vehicle_of)
    kept = plan.locked[v]
    for k in range(plan.locked[v], plan.length[v]):
        node = plan.route[v, k]
        if node >= 2 * requests or plan.vehicle_of[node >> 1] == v:
            plan.route[v, kept] = node
            kept += 1
    plan.length[v] = kept
    if not refresh(task, plan, scratch, v):
        # With different factors, a way without a visit can be longer: no such attempt is kept.
        plan.cost[v] = np.inf


@kernel
def ruin_strings(
    task: Task,
    plan: Plan,
    scratch: Scratch,
    undo: Undo,
    near: AnyArray,
    mean_out: float,
    longest: float,
    rng: AnyArray,
) -> None:
    """Take about `mean_out` requests out, in strings of at most `longest` visits.

    near  (R, K) requests by nearness to each, itself first
    """
    requests = len(plan.vehicle_of)
    visits, used = 0, 0
    for v in range(len(plan.length)):
        if plan.length[v] > plan.locked[v] + 1:
            visits += plan.length[v] - plan.locked[v] - 1
            used += 1
    if used == 0:
        return
    string_max = max(1.0, min(longest, visits / used))
    # A string of l visits takes nearly l requests out, as partners are seldom both in it.
    strings_max = 4.0 * mean_out / (1.0 + string_max) - 1.0
    strings = int(uniform(rng) * max(strings_max, 1.0) + 1.0)
    seed = below(rng, requests)
    for index in range(near.shape[1]):
        if strings == 0:
            return
        r = near[seed, index]
        v = int(np.int64(plan.vehicle_of[r]))
        if v == ABSENT or undo.touched[v] or not plan.movable[r]:
            continue
        touch(plan, undo, v)
        _cut_string(plan, undo, v, 2 * r + below(rng, 2), string_max, rng)
        close_gaps(task, plan, scratch, v)
        strings -= 1


@inlined
def _cut_string(plan: Plan, undo: Undo, v: int, node: int, string_max: float, rng: AnyArray) -> None:
    """Take out what has a visit in a random string of the route around `node`."""
    requests = len(plan.vehicle_of)
    first, last = plan.locked[v], plan.length[v] - 2
    long = last - first + 1
    length = min(long, int(uniform(rng) * min(string_max, long) + 1.0))
    kept = 0
    if length > 1 and uniform(rng) < _SPLIT:
        kept = 1
        while length + kept < long and uniform(rng) < _SPLIT_LONGER:
            kept += 1
        kept = min(kept, long - length)
    span = length + kept
    at = plan.slot[node]
    lowest, highest = max(first, at - span + 1), min(at, last - span + 1)
    begin = lowest + below(rng, highest - lowest + 1)
    hole = begin + below(rng, length + 1) if kept else begin + span
    for k in range(begin, begin + span):
        if hole <= k < hole + kept:
            continue
        other = plan.route[v, k]
        if other < 2 * requests and plan.movable[other >> 1] and plan.vehicle_of[other >> 1] == v:
            take_out(plan, undo, other >> 1)
