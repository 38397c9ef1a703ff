"""Pillars hold the returns over their square, at most so many, and every return has the same chance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from vehicle_agent.perception.pillars.grid import PillarGrid, pillars_of

GRID = PillarGrid(x_m_min=-3.2, y_m_min=-3.2, nx=32, ny=32, points_max=4)
CLOUDS = arrays.arrays(
    np.float32, st.tuples(st.integers(0, 200), st.just(4)), elements=st.floats(-5.0, 5.0, width=32)
)


def places(features: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """(p, points_max, 2) x, y of the returns in the features."""
    square = cells % (GRID.nx * GRID.ny)
    u = square % GRID.nx + 0.5
    v = square // GRID.nx + 0.5
    x = (features[:, :, 0] + u[:, None]) * GRID.cell_m + GRID.x_m_min
    y = (features[:, :, 1] + v[:, None]) * GRID.cell_m + GRID.y_m_min
    return np.stack((x, y), axis=2)


@given(points=CLOUDS, seed=st.none() | st.integers(0, 9))
@settings(max_examples=30)
def test_pillars_hold_returns_of_their_own_square(points: np.ndarray, seed: int | None) -> None:
    is_older = np.arange(len(points)) % 2 == 1
    rng = None if seed is None else np.random.default_rng(seed)
    pillars = pillars_of(points, is_older, GRID, rng)
    inside = (points[:, 0] >= -3.2) & (points[:, 0] < 3.2) & (points[:, 1] >= -3.2) & (points[:, 1] < 3.2)
    assert len(np.unique(pillars.cells)) == len(pillars.cells)
    assert (np.abs(pillars.features[:, :, :2]) <= 0.51).all()
    for cell, row in zip(pillars.cells, places(pillars.features, pillars.cells), strict=True):
        mine = points[inside & (is_older == (cell >= GRID.nx * GRID.ny))]
        for place in row:
            assert np.abs(mine[:, :2] - place).sum(axis=1).min() < 1e-3
    if inside.any():
        assert len(pillars.cells) > 0


def test_of_a_full_pillar_every_return_is_drawn_as_often() -> None:
    points = np.column_stack((np.full(20, 0.1), np.full(20, 0.1), np.arange(20.0), np.zeros(20)))
    points = points.astype(np.float32)
    rng = np.random.default_rng(1)
    drawn = np.zeros(20)
    for _ in range(500):
        features = pillars_of(points, np.zeros(20, dtype=bool), GRID, rng).features
        heights = features[0, :, 5].astype(int)
        assert len(set(heights.tolist())) == GRID.points_max
        drawn[heights] += 1
    # 500 draws of 4 from 20: each 100 times, standard deviation 9.
    assert drawn.min() > 60
    assert drawn.max() < 140


def test_without_a_generator_returns_are_taken_at_even_intervals() -> None:
    points = np.column_stack((np.full(20, 0.1), np.full(20, 0.1), np.arange(20.0), np.zeros(20)))
    features = pillars_of(points.astype(np.float32), np.zeros(20, dtype=bool), GRID).features
    assert np.diff(features[0, :, 5]).tolist() == [5.0, 5.0, 5.0]


def test_more_pillars_than_fit_leave_the_first_ones() -> None:
    few = GRID._replace(pillars_max=3)
    points = np.array([[0.1 + 0.2 * k, 0.1, 1.0, 9.0] for k in range(8)], dtype=np.float32)
    cells = pillars_of(points, np.zeros(8, dtype=bool), few).cells
    assert cells.tolist() == pillars_of(points[:3], np.zeros(3, dtype=bool), GRID).cells.tolist()


def test_a_return_that_is_no_number_is_in_no_pillar() -> None:
    points = np.array([[np.nan, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0]], dtype=np.float32)
    pillars = pillars_of(points, np.zeros(2, dtype=bool), GRID)
    assert len(pillars.cells) == 1
    assert pillars.features == pytest.approx(pillars.features)
