"""The best plan that can be put together from the routes in a pool: set partitioning, solved with HiGHS.

The linear relaxation is solved over a few columns, and columns are fetched from the pool by their
reduced cost
until none would help; then only those whose reduced cost is less than what is left to be gained can be
part of a
better plan, and the integer problem is solved over them alone.
"""

from dataclasses import dataclass

import highspy
import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.plan import ABSENT, Plan, Scratch, refresh, total_cost
from server.dispatch.engine.pool import Pool
from server.dispatch.engine.task import Task

_FETCHED_AT_ONCE = 400
_ROUNDS_MAX = 60
_REDUCED = -1e-7


@dataclass(frozen=True, slots=True)
class Partitioning:
    """How far to go, in counts. columns_max of the integer problem; nodes_max of its search tree."""

    columns_max: int = 500
    nodes_max: int = 40


@dataclass(frozen=True, slots=True)
class Master:
    """bound   least cost of any mix of the pool's routes, fractions allowed
    reduced   (C,) reduced cost of each column of the pool
    """

    bound: float
    reduced: AnyArray


class _Columns:
    """The pool as sparse columns: requests first, then one row for each kind of vehicle."""

    def __init__(self, task: Task, pool: Pool) -> None:
        n = int(pool.counts[0])
        self.count = n
        used = int(pool.counts[1])
        nodes = pool.store[:used]
        column = np.repeat(np.arange(n), pool.length[:n])
        pickups = (nodes < 2 * task.requests) & (nodes & 1 == 0)
        self.request = nodes[pickups] >> 1
        self.column = column[pickups]
        self.first = np.searchsorted(self.column, np.arange(n + 1))
        self.cost = pool.cost[:n]
        self.kind_row = task.requests + pool.kind[:n]

    def rows(self, column: int) -> AnyArray:
        rows = self.request[self.first[column] : self.first[column + 1]]
        return np.append(rows, self.kind_row[column]).astype(np.int32)

    def reduced(self, dual: AnyArray) -> AnyArray:
        """(C,) for duals (R + kinds,)."""
        sums = np.bincount(self.column, weights=dual[self.request], minlength=self.count)
        reduced: AnyArray = self.cost - sums - dual[self.kind_row]
        return reduced


def repartition(
    task: Task, plan: Plan, pool: Pool, scratch: Scratch, how: Partitioning
) -> tuple[bool, Master]:
    """Make `plan` the cheapest that the pool's routes can form, if that is cheaper than it is.

    plan's own routes must be in the pool. Returns whether it changed, and the relaxation's result.
    """
    columns = _Columns(task, pool)
    upper = total_cost(task, plan)
    model = _model(task)
    inside: list[int] = []
    held = np.zeros(columns.count, np.bool_)
    bound, reduced = -np.inf, np.zeros(columns.count)
    for _ in range(_ROUNDS_MAX):
        model.run()
        bound = model.getInfo().objective_function_value
        dual = np.array(model.getSolution().row_dual)
        reduced = columns.reduced(dual)
        wanted = np.flatnonzero((reduced < _REDUCED) & ~held)
        if len(wanted) == 0:
            break
        if len(wanted) > _FETCHED_AT_ONCE:
            wanted = wanted[np.argsort(reduced[wanted], kind="stable")[:_FETCHED_AT_ONCE]]
        held[wanted] = True
        inside.extend(int(column) for column in wanted)
        _add(model, columns, wanted)
    master = Master(bound, reduced)
    gain = upper - bound
    if gain <= 1e-6 * max(1.0, upper):
        return False, master
    useful = np.flatnonzero(reduced < gain - 1e-9)
    if len(useful) > how.columns_max:
        useful = np.sort(useful[np.argsort(reduced[useful], kind="stable")[: how.columns_max]])
    chosen = _chosen(task, columns, useful, upper, how)
    if chosen is None:
        return False, master
    _adopt(task, plan, pool, scratch, chosen)
    return True, master


def _model(task: Task) -> highspy.Highs:
    model: highspy.Highs = highspy.Highs()  # type: ignore[no-untyped-call]
    model.setOptionValue("output_flag", False)
    model.setOptionValue("threads", 1)
    model.setOptionValue("random_seed", 1)
    kinds = np.bincount(task.kind, minlength=task.vehicles)
    for _ in range(task.requests):
        model.addRow(1.0, 1.0, 0, np.empty(0, np.int32), np.empty(0))
    for kind in range(task.vehicles):
        model.addRow(-highspy.kHighsInf, float(kinds[kind]), 0, np.empty(0, np.int32), np.empty(0))
    for r in range(task.requests):
        model.addCol(float(task.absent_cost[r]), 0.0, 1.0, 1, np.array([r], np.int32), np.ones(1))
    return model


def _add(model: highspy.Highs, columns: _Columns, chosen: AnyArray) -> None:
    rows = [columns.rows(int(column)) for column in chosen]
    lengths = np.array([len(row) for row in rows])
    starts = np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.int32)
    count, entries = len(chosen), int(lengths.sum())
    model.addCols(
        count,
        columns.cost[chosen].astype(np.float64),
        np.zeros(count),
        np.ones(count),
        entries,
        starts,
        np.concatenate(rows).astype(np.int32),
        np.ones(entries),
    )


def _chosen(
    task: Task, columns: _Columns, useful: AnyArray, upper: float, how: Partitioning
) -> list[int] | None:
    """The columns of a plan that costs less than `upper`, or None."""
    model = _model(task)
    _add(model, columns, useful)
    total = task.requests + len(useful)
    model.changeColsIntegrality(
        total, np.arange(total, dtype=np.int32), np.full(total, highspy.HighsVarType.kInteger)
    )
    model.setOptionValue("mip_max_nodes", how.nodes_max)
    model.setOptionValue("mip_rel_gap", 0.0)
    model.setOptionValue("mip_abs_gap", 1e-6)
    model.setOptionValue("objective_bound", upper - 1e-6)
    model.run()
    values = np.array(model.getSolution().col_value)
    if len(values) < total or model.getInfo().objective_function_value >= upper - 1e-6:
        return None
    return [int(column) for column in useful[values[task.requests :] > 0.5]]


def _adopt(task: Task, plan: Plan, pool: Pool, scratch: Scratch, chosen: list[int]) -> None:
    """Give each chosen route to a vehicle of its kind; vehicles left over stay empty."""
    free = {int(kind): [int(v) for v in np.flatnonzero(task.kind == kind)] for kind in np.unique(task.kind)}
    plan.vehicle_of[plan.movable] = ABSENT
    taken = []
    for column in chosen:
        v = free[int(pool.kind[column])].pop(0)
        first, n = pool.first[column], pool.length[column]
        nodes = pool.store[first : first + n].copy()
        # The route may have been driven by another vehicle of the kind.
        start = 2 * (task.requests + v)
        nodes[0], nodes[-1] = start, start + 1
        plan.route[v, :n], plan.length[v] = nodes, n
        requests = nodes[(nodes < 2 * task.requests)] >> 1
        plan.vehicle_of[requests] = v
        taken.append(v)
        refresh(task, plan, scratch, v)
    for v in range(task.vehicles):
        if v not in taken:
            locked = int(plan.locked[v])
            plan.route[v, locked] = 2 * (task.requests + v) + 1
            plan.length[v] = locked + 1
            refresh(task, plan, scratch, v)
