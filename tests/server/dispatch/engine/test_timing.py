"""Exact times: held to linear programming on random routes."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from campusloop.studies.instances.task import task_of
from server.dispatch.engine.plan import empty_plan, refresh, scratch_for
from server.dispatch.engine.task import Task, drive_s
from tests.server.dispatch.engine.instances import small_instance


def _rules(task: Task, nodes: list[int]) -> tuple[list[list[float]], list[float], list[tuple[float, float]]]:
    """A x <= b and bounds for the beginnings of a route's visits."""
    n = len(nodes)
    rows, limits = [], []
    for k in range(1, n):
        row = [0.0] * n
        row[k - 1], row[k] = 1.0, -1.0
        rows.append(row)
        limits.append(-float(task.service_s[nodes[k - 1]]) - drive_s(task, nodes[k - 1], nodes[k]))
    for k, node in enumerate(nodes):
        if node % 2 and np.isfinite(task.ride_s_max[node - 1]):
            row = [0.0] * n
            row[k], row[nodes.index(node - 1)] = 1.0, -1.0
            rows.append(row)
            limits.append(float(task.ride_s_max[node - 1] + task.service_s[node - 1]))
    return rows, limits, [(float(task.early_s[node]), float(task.late_s[node])) for node in nodes]


@settings(deadline=None, max_examples=150)
@given(
    seed=st.integers(0, 10_000), order=st.randoms(use_true_random=False), ride=st.sampled_from([12.0, 40.0])
)
def test_a_route_is_feasible_exactly_when_its_linear_program_is(
    seed: int, order: object, ride: float
) -> None:
    task = task_of(small_instance(seed, 3, vehicles=1, ride_max=ride))
    if (task.early_s > task.late_s).any():
        return
    visits = list(range(6))
    order.shuffle(visits)  # type: ignore[attr-defined]
    visits.sort(key=lambda node: (task.early_s[node] // 60.0, node % 2))
    plan = empty_plan(task, 10)
    nodes = [6, *visits, 7]
    plan.route[0, :8], plan.length[0] = nodes, 8
    task.capacity[:] = 99
    feasible = refresh(task, plan, scratch_for(task, 10), 0)
    if any(nodes.index(2 * r) > nodes.index(2 * r + 1) for r in range(3)):
        return
    rows, limits, bounds = _rules(task, nodes)
    least = linprog(np.ones(8), rows, limits, bounds=bounds)
    assert feasible == (least.status == 0)
    if feasible:
        greatest = linprog(-np.ones(8), rows, limits, bounds=bounds)
        np.testing.assert_allclose(plan.least_s[0, :8], least.x, atol=1e-5)
        np.testing.assert_allclose(plan.most_s[0, :8], greatest.x, atol=1e-5)
