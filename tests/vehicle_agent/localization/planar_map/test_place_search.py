"""Branch and bound finds what scoring every pose finds; and what a scan sees counts by things."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array, wrap_angle
from contract.occupancy.occupancy_map import FREE, OCCUPIED, Cells, OccupancyMap
from vehicle_agent.localization.monte_carlo.likelihood_field import FieldParams, likelihood_field
from vehicle_agent.localization.planar_map.agreement import EvidenceParams, evidence_at, things_of
from vehicle_agent.localization.planar_map.place_search import PlaceSearchParams, places_of, search_grid

CELL_M = 0.1
PARAMS = PlaceSearchParams(levels=4, range_m=4.0, score_min=0.2, nodes_max=10_000_000)
SIDE = 300
MIDDLE_M, HALF_M = 0.5 * SIDE * CELL_M, 6.0


def field_of_walls(seed: int) -> Cells:
    rng = np.random.default_rng(seed)
    cells: Cells = np.full((SIDE, SIDE), FREE, dtype=np.uint8)
    for row, column, rows, columns in rng.integers(0, SIDE, (25, 4)) // np.array([1, 1, 12, 12]):
        cells[row : row + 1 + rows, column : column + 1 + columns] = OCCUPIED
    return cells


def every_score(points: Array, cells: Cells, yaws: Array) -> float:
    """The best share of all poses of the lattice, each scored by itself."""
    grid = search_grid(cells, CELL_M, 0.0, 0.0, PARAMS)
    values, free, cell_m = grid.values[0], grid.free[0], grid.cell_m
    first, last = math.floor((MIDDLE_M - HALF_M) / cell_m), math.ceil((MIDDLE_M + HALF_M) / cell_m)
    best = 0.0
    for yaw in yaws:
        dx = np.floor(0.5 + (np.cos(yaw) * points[:, 0] - np.sin(yaw) * points[:, 1]) / cell_m).astype(int)
        dy = np.floor(0.5 + (np.sin(yaw) * points[:, 0] + np.cos(yaw) * points[:, 1]) / cell_m).astype(int)
        for row in range(first, last):
            for column in range(first, last):
                if free[row, column]:
                    best = max(best, float(values[row + dy, column + dx].sum()))
    return best / (4.0 * len(points))


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_the_best_pose_is_as_good_as_the_best_of_all(seed: int) -> None:
    cells = field_of_walls(seed)
    rng = np.random.default_rng([seed, 1])
    points: Array = rng.uniform(-3.0, 3.0, (6, 2))
    grid = search_grid(cells, CELL_M, 0.0, 0.0, PARAMS)
    found = places_of(points, np.ones(6), grid, (MIDDLE_M, MIDDLE_M, HALF_M), (0.3, 0.1), 0.0, PARAMS)
    far_m = max(5.0, float(np.hypot(*points.T).max()))
    turns = max(1, math.ceil(0.2 / (grid.cell_m / far_m)))
    yaws = 0.2 + 0.2 / turns * (np.arange(turns) + 0.5)
    best = every_score(points, cells, yaws)
    assert (found[0].score if found else 0.0) == (best if best >= PARAMS.score_min else 0.0)
    assert all(one.score >= other.score for one, other in itertools.pairwise(found))
    for number, one in enumerate(found):
        for other in found[:number]:
            apart_m = math.hypot(*(one.pose[:2] - other.pose[:2]))
            turn_rad = abs(wrap_angle(float(one.pose[2] - other.pose[2])))
            assert apart_m >= PARAMS.apart_m - 1e-9 or turn_rad >= PARAMS.apart_rad


def test_a_truck_counts_as_one_thing_however_many_beams_it_stops() -> None:
    cells: Cells = np.full((SIDE, SIDE), FREE, dtype=np.uint8)
    posts = [(5.0, 3.0), (5.0, -3.0), (-4.0, 4.0), (-5.0, -2.0)]
    for x, y in posts:
        row, column = round((MIDDLE_M + y) / CELL_M), round((MIDDLE_M + x) / CELL_M)
        cells[row - 1 : row + 2, column - 1 : column + 2] = OCCUPIED
    field = likelihood_field(OccupancyMap(cells, CELL_M, 0.0, 0.0), FieldParams())
    params = EvidenceParams()
    truck = np.column_stack((np.full(50, 2.5), np.linspace(-1.2, 1.2, 50)))
    points: Array = np.concatenate([[posts[3], posts[1]], truck, [posts[0], posts[2]]])
    here = np.array([MIDDLE_M, MIDDLE_M, 0.0])
    evidence = evidence_at(points, things_of(points, params), here, field, params)
    assert evidence.on == pytest.approx(4.0 * params.on_wall)
    assert evidence.against == pytest.approx(params.beside_walls)
    elsewhere = evidence_at(
        points, things_of(points, params), here + np.array([1.5, 0.0, 0.0]), field, params
    )
    assert elsewhere.agreement(params.prior) < 0.5 < evidence.agreement(params.prior)
