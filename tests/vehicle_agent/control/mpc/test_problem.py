"""Quadratic problems of one actuator: exact without bounds, right with them, and forgetful."""

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are
from scipy.optimize import LinearConstraint, minimize

from contract.geometry import Array
from vehicle_agent.control.mpc.axis import cold_start, solve_axis
from vehicle_agent.control.mpc.bounded import InputBounds, are_within, solve_bounded
from vehicle_agent.control.mpc.lateral_model import Chassis, exponential, rates_matrix
from vehicle_agent.control.mpc.problem import AxisProblem, condense, end_cost, unconstrained_inputs

N, DT = 40, 0.05


def a_problem(seed: int) -> AxisProblem:
    """Three states, the last of them the command that the input adds up to."""
    rng = np.random.default_rng(seed)
    M = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, -0.3, 2.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0] * 4])
    step = expm(M * DT)
    A, B = np.tile(step[:3, :3], (N, 1, 1)), np.tile(step[:3, 3], (N, 1))
    d = rng.normal(0.0, 0.01, (N, 3)) * np.array((1.0, 1.0, 0.0))
    Q = np.tile(np.diag((20.0, 2.0, 0.0)) * DT, (N, 1, 1))
    P = end_cost(A[0], B[0], Q[0], 0.02, 3000)
    w, x_end, x0 = rng.normal(0.0, 0.1, N), rng.normal(0.0, 0.05, 3), rng.normal(0.0, 0.5, 3)
    return AxisProblem(A, B, d, Q, 0.02, w, P, x_end, x0)


def cost(
    u: Array, A: Array, B: Array, d: Array, Q: Array, R: float, w: Array, P: Array, x_end: Array, x0: Array
) -> float:
    x, total = x0, 0.0
    for k in range(N):
        total += x @ Q[k] @ x + R * (u[k] - w[k]) ** 2
        x = A[k] @ x + B[k] * u[k] + d[k]
    return float(total + (x - x_end) @ P @ (x - x_end))


@pytest.mark.parametrize("seed", range(5))
def test_free_inputs_are_where_the_condensed_gradient_vanishes(seed: int) -> None:
    problem = a_problem(seed)
    H, g = condense(problem)
    u = unconstrained_inputs(problem)
    assert np.abs(H @ u + g).max() < 1e-9 * np.abs(g).max()
    rng = np.random.default_rng(seed)
    assert all(cost(u, *problem) < cost(u + rng.normal(0.0, 0.01, N), *problem) for _ in range(20))


@pytest.mark.parametrize("seed", range(5))
def test_bounded_inputs_agree_with_an_independent_solver(seed: int) -> None:
    problem = a_problem(seed)
    bounds = InputBounds(0.4, problem.x0[2] - 0.3, problem.x0[2] + 0.2)
    answer = solve_axis(problem, bounds, DT, cold_start(N))
    assert answer.bounded
    assert answer.feasible
    H, g = condense(problem)
    sums = DT * np.tril(np.ones((N, N)))
    oracle = minimize(
        lambda u: 0.5 * u @ H @ u + g @ u,
        np.zeros(N),
        jac=lambda u: H @ u + g,
        bounds=[(-bounds.rate, bounds.rate)] * N,
        constraints=[LinearConstraint(sums, -0.3, 0.2)],
        method="SLSQP",
        options={"maxiter": 1000, "ftol": 1e-14},
    )
    assert are_within(
        answer.inputs,
        problem.x0[2],
        InputBounds(0.4 + 1e-9, bounds.command_min - 1e-9, bounds.command_max + 1e-9),
        DT,
    )
    gap = 0.5 * answer.inputs @ H @ answer.inputs + g @ answer.inputs - oracle.fun
    assert gap < 2e-3 * abs(oracle.fun)
    assert answer.inputs[0] == pytest.approx(oracle.x[0], abs=0.02)


def test_what_the_solver_did_before_changes_nothing() -> None:
    first, second = a_problem(1), a_problem(2)
    H, g = condense(first)
    bounds = InputBounds(0.4, -2.0, 2.0)
    args = (H, g, float(first.x0[2]), bounds, DT, np.zeros(N), np.zeros(2 * N))
    before = solve_bounded(*args)
    for rate in (0.01, 3.0):
        H2, g2 = condense(second)
        solve_bounded(
            H2, 100.0 * g2, float(second.x0[2]), InputBounds(rate, -2.0, 2.0), DT, np.ones(N), np.ones(2 * N)
        )
    after = solve_bounded(*args)
    assert np.array_equal(before.inputs, after.inputs)
    assert np.array_equal(before.multipliers, after.multipliers)


def test_the_end_cost_solves_the_riccati_equation() -> None:
    A, B, _, Q, R, *_ = a_problem(0)
    oracle = solve_discrete_are(A[0], B[0][:, None], Q[0], np.array([[R]]))
    assert np.allclose(end_cost(A[0], B[0], Q[0], R, 5000), oracle, rtol=1e-6)


@pytest.mark.parametrize("speed", [0.0, 0.3, 1.0, 1.5, 2.0, 3.0, 6.0])
@pytest.mark.parametrize("compliance", [0.02, 1.0, 2.0])
def test_the_model_has_finite_steps_that_do_not_grow_at_any_speed(speed: float, compliance: float) -> None:
    M, step = np.zeros((9, 9)), np.zeros((9, 9))
    rates_matrix(speed, compliance, Chassis().row(), M)
    exponential(M, DT, step)
    assert np.isfinite(step).all()
    assert np.abs(np.linalg.eigvals(step[:6, :6])).max() < 1.0 + 1e-6
    # What a tenth of a second leaves of it is right, however stiff it is inside.
    twice, exact = step @ step, expm(M * 2.0 * DT)
    assert np.abs(twice[[0, 2]] - exact[[0, 2]]).max() < 0.02


def test_a_steady_circle_is_one_of_the_models_equilibria() -> None:
    chassis, speed, kappa = Chassis(), 3.0, 0.05
    M = np.zeros((9, 9))
    rates_matrix(speed, 1.0, chassis.row(), M)
    side = speed * speed * kappa
    slip = chassis.rear_slip_per_mps2 * side
    wheels = chassis.wheelbase_m * kappa + chassis.understeer_s2pm * side
    z = np.array((chassis.cog_to_rear_m * slip, 0.0, slip, 0.0, wheels, wheels, speed * kappa, 0.0, 0.0))
    assert np.abs(M @ z).max() < 1e-12


def test_a_chassis_without_mass_is_refused() -> None:
    with pytest.raises(ValueError, match="positive"):
        Chassis(mass_kg=0.0)
