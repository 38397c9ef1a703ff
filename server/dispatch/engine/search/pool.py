"""Routes worth remembering: one for each set of requests, the cheapest order that was met."""

from typing import NamedTuple

import numpy as np
from numba import uint64

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel
from server.dispatch.engine.draw import bits, seeded
from server.dispatch.engine.plan import Plan
from server.dispatch.engine.task import Task

NO_COLUMN = -1
# Visits of a route that is only a start and an end.
_WITHOUT_VISITS = 2
# Sets are told apart by 64-bit sums of random marks (Zobrist 1970); they are the same in every run.
_MARKS_SEED = 0x5E7


class RoutePool(NamedTuple):
    """Columns of a set partitioning.

    marks, kind_marks   (R,), (V,) uint64
    table       (H,) hash table of column numbers, a power of two
    key, cost, kind, first, length   (C,) of each column: its nodes are store[first : first + length]
    store       (S,) int32
    counts      columns and store in use
    """

    marks: AnyArray
    kind_marks: AnyArray
    table: AnyArray
    key: AnyArray
    cost: AnyArray
    kind: AnyArray
    first: AnyArray
    length: AnyArray
    store: AnyArray
    counts: AnyArray


def empty_pool(task: Task, columns: int, visits: int) -> RoutePool:
    """Room for so many columns with so many visits in all; further ones are not kept."""
    state = seeded(_MARKS_SEED)
    size = 1 << (2 * columns - 1).bit_length()
    return RoutePool(
        marks=np.array([bits(state) for _ in range(task.requests)], dtype=np.uint64),
        kind_marks=np.array([bits(state) for _ in range(task.vehicles)], dtype=np.uint64),
        table=np.full(size, NO_COLUMN, np.int32),
        key=np.zeros(columns, np.uint64),
        cost=np.zeros(columns),
        kind=np.zeros(columns, np.int32),
        first=np.zeros(columns, np.int64),
        length=np.zeros(columns, np.int32),
        store=np.zeros(visits, np.int32),
        counts=np.zeros(2, np.int64),
    )


@kernel
def remember(task: Task, pool: RoutePool, plan: Plan, v: int) -> int:
    """Keep a vehicle's route if it is new, or cheaper than the one with the same requests.

    Returns its column; NO_COLUMN for a vehicle without a visit, or where there is no room.
    """
    n = plan.length[v]
    if n == _WITHOUT_VISITS:
        return NO_COLUMN
    kind = task.kind[v]
    key = pool.kind_marks[kind]
    requests = len(pool.marks)
    for k in range(plan.locked[v], n - 1):
        node = plan.route[v, k]
        if node < 2 * requests and node & 1 == 0:
            key ^= pool.marks[node >> 1]
    mask = uint64(len(pool.table) - 1)
    place = np.int64(key & mask)
    column = pool.table[place]
    while column != NO_COLUMN and pool.key[column] != key:
        place = np.int64((uint64(place) + uint64(1)) & mask)
        column = pool.table[place]
    if column == NO_COLUMN:
        column = pool.counts[0]
        first = pool.counts[1]
        if column == len(pool.key) or first + n > len(pool.store):
            return NO_COLUMN
        pool.counts[0] += 1
        pool.counts[1] += n
        pool.table[place] = column
        pool.key[column], pool.kind[column] = key, kind
        pool.first[column], pool.length[column] = first, n
    elif pool.cost[column] <= plan.cost[v]:
        return int(column)
    pool.cost[column] = plan.cost[v]
    first = pool.first[column]
    for k in range(n):
        pool.store[first + k] = plan.route[v, k]
    return int(column)
