"""The path: the prior, its linear algebra, and that the solver finds the optimum."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array
from tests.vehicle_agent.planning.motion.path.path_problems import a_problem, cost_and_slopes, problem_with
from vehicle_agent.planning.motion.path.banded import factorize, solve
from vehicle_agent.planning.motion.path.gp_path import solve_path
from vehicle_agent.planning.motion.path.gp_prior import (
    covariance,
    information,
    interpolation,
    states_between,
    transition,
)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000), width=st.integers(1, 6), n=st.integers(2, 20))
def test_the_band_solver_agrees_with_a_dense_one(seed: int, width: int, n: int) -> None:
    random = np.random.default_rng(seed)
    root = np.tril(random.normal(size=(n, n)))
    root[np.subtract.outer(np.arange(n), np.arange(n)) > width] = 0.0
    dense = root @ root.T + np.eye(n)
    dense[np.abs(np.subtract.outer(np.arange(n), np.arange(n))) > width] = 0.0
    dense += n * np.eye(n)
    band = np.zeros((width + 1, n))
    for d in range(min(width + 1, n)):
        band[d, : n - d] = np.diagonal(dense, -d)
    b = random.normal(size=n)
    expected = np.linalg.solve(dense, b)
    assert factorize(band)
    solve(band, b)
    assert np.allclose(b, expected, atol=1e-10)


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    assert not factorize(np.array([[1.0, -1.0], [0.0, 0.0]]))


def test_information_is_the_inverse_of_the_covariance() -> None:
    for step in (0.5, 2.0, 3.0):
        assert np.allclose(information(step) @ covariance(step), np.eye(3), atol=1e-8)


def test_between_two_supports_the_mean_is_the_quintic_that_joins_them() -> None:
    random = np.random.default_rng(3)
    x: Array = random.normal(size=(2, 3))
    for tau in (0.4, 1.0, 1.7):
        by_matrix = interpolation(2.0, tau) @ x.ravel()
        by_hermite = states_between(x, 2.0, 0.0, np.array([tau]))[0]
        assert by_matrix == pytest.approx(by_hermite, abs=1e-9)
    assert np.allclose(interpolation(2.0, 1e-9)[:, :3], np.eye(3), atol=1e-5)
    assert transition(2.0)[0, 2] == 2.0


@pytest.mark.parametrize("seed", range(6))
def test_the_gradient_is_that_of_the_cost(seed: int) -> None:
    problem = a_problem(seed)
    random = np.random.default_rng(seed)
    x = np.column_stack([problem.reference, 0.0 * problem.reference, 0.0 * problem.reference])
    x += random.normal(size=x.shape) * (0.4, 0.1, 0.05)
    _, _, gradient = cost_and_slopes(problem, x)
    numeric = np.zeros(x.size)
    for i in range(x.size):
        step = np.zeros(x.size)
        step[i] = 1e-7
        up, _, _ = cost_and_slopes(problem, x + step.reshape(x.shape))
        down, _, _ = cost_and_slopes(problem, x - step.reshape(x.shape))
        numeric[i] = (up - down) / 2e-7
    scale = np.abs(numeric).max()
    # The body disc's place beside a wall is read at the nearest check point: its slope is exact, too.
    assert np.abs(gradient - numeric).max() < 1e-4 * scale


@pytest.mark.parametrize("seed", range(6))
def test_at_the_solution_no_step_is_left_to_take(seed: int) -> None:
    problem = a_problem(seed)
    start = np.zeros((len(problem.reference), 3))
    start[:, 0] = problem.reference
    start[0] = problem.start
    path = solve_path(problem, start, 200)
    cost, band, gradient = cost_and_slopes(problem, path.states)
    assert cost == pytest.approx(path.cost)
    assert factorize(band)
    solve(band, gradient)
    assert np.abs(gradient[::3]).max() < 1e-6


def test_a_warm_start_needs_fewer_iterations_to_the_same_path() -> None:
    problem = a_problem(2)
    cold = solve_path(problem, np.zeros((len(problem.reference), 3)), 200)
    warm = solve_path(problem, cold.states, 200)
    assert warm.iterations < cold.iterations
    assert np.allclose(warm.states[:, 0], cold.states[:, 0], atol=1e-6)


def test_the_path_keeps_the_start_the_walls_and_the_obstacle() -> None:
    problem = problem_with(obstacles=np.array([[18.0, 0.4, 0.3]]), room_m=1.2, start=(0.4, 0.05, 0.0))
    guess = np.zeros((len(problem.reference), 3))
    path = solve_path(problem, guess, 100)
    assert path.states[0] == pytest.approx((0.4, 0.05, 0.0), abs=1e-6)
    l_m = path.at(np.linspace(path.first_m, path.first_m + 40.0, 400))[:, 0]
    assert np.abs(l_m).max() < 1.2
    # The body is 0.815 m wide on each side and the obstacle reaches down to 0.1 m.
    beside = path.at(np.array([16.0, 17.0, 18.0]))[:, 0]
    assert (beside + 0.815 < 0.1).all()
