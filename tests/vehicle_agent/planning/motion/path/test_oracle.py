"""A factor graph in gtsam, with residuals of its own, finds the same path (extra `oracle`)."""

import numpy as np
import pytest

from tests.vehicle_agent.planning.motion.path.path_problems import a_problem
from vehicle_agent.planning.motion.path.gp_path import solve_path

pytest.importorskip("gtsam", reason="gtsam is not installed: make oracle")


@pytest.mark.parametrize("seed", range(6))
def test_gtsam_finds_the_same_path(seed: int) -> None:
    from benchmarks.planner.oracle import oracle_path

    problem = a_problem(seed)
    guess = np.zeros((len(problem.reference), 3))
    guess[:, 0] = problem.reference
    guess[0] = problem.start
    ours = solve_path(problem, guess, 300)
    theirs, _ = oracle_path(problem, guess)
    assert np.abs(ours.states[:, 0] - theirs[:, 0]).max() < 1e-6
