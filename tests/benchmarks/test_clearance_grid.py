"""The early-out of the clearance grid changes no clearance."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.planner.clearance_grid import clearance_grid
from vehicle_agent.planning.motion.clearance import Box

BOX = Box(3.5, 0.85, 0.815)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), cap_m=st.floats(0.1, 4.0), agents=st.integers(0, 40))
def test_the_grid_with_early_out_equals_brute_force_cell_by_cell(
    seed: int, cap_m: float, agents: int
) -> None:
    random = np.random.default_rng(seed)
    curvature = random.uniform(-0.15, 0.15)
    s, offsets = 0.5 * np.arange(30), np.linspace(-2.0, 2.0, 9)
    yaw = np.repeat((curvature * s)[:, None], 9, axis=1) + random.normal(0.0, 0.02, (30, 9))
    poses = np.stack([s[:, None] - offsets * np.sin(yaw), offsets * np.cos(yaw), yaw], axis=2)
    discs = random.uniform((-10.0, -10.0, 0.1), (25.0, 10.0, 1.0), size=(6, agents, 3))
    quick, computed = clearance_grid(poses, discs, BOX, cap_m)
    brute, every = clearance_grid(poses, discs, BOX, cap_m, early_out=False)
    assert np.array_equal(quick, brute)
    assert computed <= every == brute.size


def test_far_from_everything_few_cells_are_computed() -> None:
    s, offsets = 0.5 * np.arange(60), np.linspace(-1.5, 1.5, 15)
    poses = np.zeros((60, 15, 3))
    poses[:, :, 0], poses[:, :, 1] = s[:, None], offsets
    discs = np.array([[[40.0, 20.0, 0.3]]])
    _, computed = clearance_grid(poses, discs, BOX, 1.6)
    assert computed < 0.2 * 60 * 15


def test_without_discs_every_clearance_is_the_cap() -> None:
    grid, _ = clearance_grid(np.zeros((2, 2, 3)), np.empty((3, 0, 3)), BOX, 1.6)
    assert (grid == 1.6).all()
