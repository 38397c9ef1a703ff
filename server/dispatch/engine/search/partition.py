"""The best plan that can be put together from the routes in a pool: set partitioning, solved with HiGHS.

The linear relaxation is solved over a few columns, and columns are fetched from the pool by their reduced
cost until none would help. Only columns whose reduced cost is less than the possible gain can be part of a
better plan, and the integer problem is solved over them alone.

A vehicle that is bound (riders aboard, visits that stay, timed calls) has exactly one route; any other has at
most one. A request whose absence costs more than all the driving keeps its place.
"""

from dataclasses import dataclass

import highspy
import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.plan import ABSENT, Plan, Scratch, copy_plan, empty_plan, refresh, total_cost
from server.dispatch.engine.search.pool import NO_COLUMN, RoutePool, remember
from server.dispatch.engine.task import Task

_FETCHED_AT_ONCE = 400
_ROUNDS_MAX = 60
_REDUCED = -1e-7
_GAIN = 1e-6


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


class _Rules:
    """What every mix of routes has to keep: one row for each request, then one for each kind of vehicle.

    absent   (R,) cost of leaving a request out as the solver sees it: no more than outweighs all the rest,
             as costs that are many powers of ten apart have no digits left for seconds
    served   (R,) bool, whether the request has a row that counts; riders aboard and visits that stay have
             none, because the vehicle's own row is enough
    least, most   (kinds,) routes of each kind
    idle     (V,) cost of a vehicle's route without a visit
    constant      cost of all vehicles without one that need not drive
    """

    def __init__(self, task: Task, plan: Plan, scratch: Scratch) -> None:
        vehicles = task.vehicles
        bound = plan.locked > 1
        bound[plan.vehicle_of[~plan.movable & (plan.vehicle_of != ABSENT)]] = True
        timed = 2 * (task.requests + vehicles)
        for v in range(vehicles):
            bound[v] |= bool((plan.route[v, : plan.length[v]] >= timed).any())
        self.most = np.bincount(task.kind, minlength=vehicles).astype(float)
        if (self.most[task.kind[bound]] > 1).any():
            raise ValueError("a vehicle that is bound to something must be the only one of its kind")
        self.least = np.full(vehicles, -highspy.kHighsInf)
        self.least[task.kind[bound]] = 1.0
        self.served = plan.movable
        idle = empty_plan(task, 2)
        for v in range(vehicles):
            refresh(task, idle, scratch, v)
        self.idle = np.where(bound, 0.0, idle.cost)
        self.idle_of_kind = np.zeros(vehicles)
        self.idle_of_kind[task.kind] = self.idle
        self.constant = float(self.idle.sum())
        driving = float(plan.cost.sum()) + 1.0
        outside = plan.vehicle_of == ABSENT
        most = np.where(outside, driving, driving * (2.0 + outside.sum()))
        self.absent = np.where(self.served, np.minimum(task.absent_cost, most), 0.0)

    def cost(self, plan: Plan) -> float:
        """Of a plan as the solver sees it, vehicles without a visit left out."""
        left_out = self.absent[(plan.vehicle_of == ABSENT) & self.served].sum()
        return float(plan.cost.sum() + left_out) - self.constant


class _Columns:
    """The pool as sparse columns: requests first, then one row for each kind of vehicle."""

    def __init__(self, task: Task, pool: RoutePool, rules: _Rules) -> None:
        n = int(pool.counts[0])
        self.count = n
        used = int(pool.counts[1])
        nodes = pool.store[:used]
        column = np.repeat(np.arange(n), pool.length[:n])
        pickups = (nodes < 2 * task.requests) & (nodes & 1 == 0)
        pickups[pickups] = rules.served[nodes[pickups] >> 1]
        self.request = nodes[pickups] >> 1
        self.column = column[pickups]
        self.first = np.searchsorted(self.column, np.arange(n + 1))
        self.cost = pool.cost[:n] - rules.idle_of_kind[pool.kind[:n]]
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
    task: Task, plan: Plan, pool: RoutePool, scratch: Scratch, how: Partitioning
) -> tuple[bool, Master]:
    """Make `plan` the cheapest that the pool's routes can form, if that is cheaper than it is.

    Returns whether it changed, and the relaxation's result. Raises ValueError where a vehicle bound to
    something is not the only one of its kind.
    """
    own = np.array([remember(task, pool, plan, v) for v in range(task.vehicles)])
    own = np.sort(own[own != NO_COLUMN])
    rules = _Rules(task, plan, scratch)
    columns = _Columns(task, pool, rules)
    upper = rules.cost(plan)
    if not np.isin(np.flatnonzero(rules.least > 0.0), pool.kind[own]).all():
        # The pool is full, and some vehicle's own route is not in it.
        return False, Master(-np.inf, np.zeros(columns.count))
    model = _model(rules)
    held = np.zeros(columns.count, np.bool_)
    bound, reduced, wanted = -np.inf, np.zeros(columns.count), own
    for _ in range(_ROUNDS_MAX):
        if len(wanted):
            held[wanted] = True
            _add(model, columns, wanted)
        model.run()
        bound = model.getInfo().objective_function_value
        reduced = columns.reduced(np.array(model.getSolution().row_dual))
        wanted = np.flatnonzero((reduced < _REDUCED) & ~held)
        if len(wanted) == 0:
            break
        if len(wanted) > _FETCHED_AT_ONCE:
            wanted = wanted[np.argsort(reduced[wanted], kind="stable")[:_FETCHED_AT_ONCE]]
    master = Master(bound + rules.constant, reduced)
    gain = upper - bound
    if gain <= _GAIN * max(1.0, upper):
        return False, master
    useful = np.flatnonzero(reduced < gain - 1e-9)
    if len(useful) > how.columns_max:
        useful = useful[np.argsort(reduced[useful], kind="stable")[: how.columns_max]]
    useful = np.union1d(useful, own)
    chosen = _chosen(rules, columns, useful, upper, how)
    if chosen is None:
        return False, master
    mix = _mixed(task, plan, pool, scratch, chosen)
    if mix is None or total_cost(task, mix) >= total_cost(task, plan):
        return False, master
    copy_plan(plan, mix)
    return True, master


def _model(rules: _Rules) -> highspy.Highs:
    model: highspy.Highs = highspy.Highs()  # type: ignore[no-untyped-call]
    model.setOptionValue("output_flag", False)
    model.setOptionValue("threads", 1)
    model.setOptionValue("random_seed", 1)
    rows = len(rules.served) + len(rules.least)
    served = rules.served.astype(float)
    least, most = np.concatenate([served, rules.least]), np.concatenate([served, rules.most])
    model.addRows(rows, least, most, 0, np.zeros(rows, np.int32), np.empty(0, np.int32), np.empty(0))
    requests = len(rules.served)
    own_row = np.arange(requests, dtype=np.int32)
    model.addCols(
        requests, rules.absent, np.zeros(requests), served, requests, own_row, own_row, np.ones(requests)
    )
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
    rules: _Rules, columns: _Columns, useful: AnyArray, upper: float, how: Partitioning
) -> list[int] | None:
    """The columns of a plan that costs less than `upper`, or None."""
    model = _model(rules)
    _add(model, columns, useful)
    requests = len(rules.served)
    total = requests + len(useful)
    model.changeColsIntegrality(
        total, np.arange(total, dtype=np.int32), np.full(total, highspy.HighsVarType.kInteger)
    )
    model.setOptionValue("mip_max_nodes", how.nodes_max)
    model.setOptionValue("mip_rel_gap", 0.0)
    model.setOptionValue("mip_abs_gap", 1e-6)
    model.setOptionValue("objective_bound", upper - _GAIN)
    model.run()
    info = model.getInfo()
    if info.primal_solution_status != highspy.SolutionStatus.kSolutionStatusFeasible:
        return None
    values = np.array(model.getSolution().col_value)
    if len(values) < total or info.objective_function_value >= upper - _GAIN:
        return None
    return [int(column) for column in useful[values[requests:] > 0.5]]


def _mixed(task: Task, plan: Plan, pool: RoutePool, scratch: Scratch, chosen: list[int]) -> Plan | None:
    """The plan in which each chosen route has a vehicle of its kind; vehicles left over have no visits.

    None where a rule breaks: with travel time factors a detour may be quicker, and an idle vehicle late.
    """
    mix = empty_plan(task, plan.route.shape[1])
    copy_plan(mix, plan)
    mix.vehicle_of[plan.movable] = ABSENT
    free = {int(kind): [int(v) for v in np.flatnonzero(task.kind == kind)] for kind in np.unique(task.kind)}
    taken = []
    for column in chosen:
        v = free[int(pool.kind[column])].pop(0)
        first, n = pool.first[column], pool.length[column]
        nodes = pool.store[first : first + n].copy()
        # The route may have been driven by another vehicle of the kind.
        start = 2 * (task.requests + v)
        nodes[0], nodes[-1] = start, start + 1
        mix.route[v, :n], mix.length[v] = nodes, n
        mix.vehicle_of[nodes[nodes < 2 * task.requests] >> 1] = v
        taken.append(v)
    for v in range(task.vehicles):
        if v not in taken:
            mix.route[v, 1], mix.length[v] = 2 * (task.requests + v) + 1, 2
        if not refresh(task, mix, scratch, v):
            return None
    return mix
