"""The rolling cost map and the speeds that it leaves."""

import math

import numpy as np
import pytest

from vehicle_agent.planning.cost_map.cost_map import (
    CELL_M,
    OBSTACLE,
    SIDE,
    SIDE_M,
    UNKNOWN,
    CostMap,
    CostRules,
    ahead_of,
    obstacle_cells,
    rolled,
    seen_in,
)
from vehicle_agent.planning.cost_map.safe_speeds import SafeSpeeds

RULES = CostRules()
HERE = np.zeros(2)


def a_map(*points: tuple[float, float], x_m: float = 0.0, before: CostMap | None = None) -> CostMap:
    seen = np.array(points, dtype=float).reshape(-1, 2)
    return RULES.updated(before or RULES.empty(), x_m, 0.0, np.array([x_m, 0.0]), seen)


def at(costs: CostMap, x_m: float, y_m: float) -> int:
    row, column = math.floor(y_m / CELL_M) - costs.row, math.floor(x_m / CELL_M) - costs.column
    return int(costs.cells[row, column])


def test_the_map_is_fifty_metres_in_bytes_and_begins_unknown() -> None:
    cells = RULES.empty().cells
    assert cells.dtype == np.uint8
    assert cells.shape == (SIDE, SIDE) == (250, 250)
    assert SIDE * CELL_M == SIDE_M
    assert np.all(cells == UNKNOWN)


def test_costs_fall_off_exponentially_around_an_obstacle() -> None:
    costs = a_map((5.1, 0.1))
    assert at(costs, 5.1, 0.1) == OBSTACLE
    for cells in (1, 2, 4, 6):
        wanted = math.floor(253 * math.exp(-cells * CELL_M / RULES.decay_m))
        assert at(costs, 5.1 - cells * CELL_M, 0.1) == wanted
    assert at(costs, 5.1 - 8 * CELL_M, 0.1) == 0


def test_the_dearest_of_several_obstacles_counts() -> None:
    one, two = a_map((5.1, 0.1)), a_map((5.1, 0.1), (5.1, 1.1))
    assert at(two, 5.1, 0.7) > at(one, 5.1, 0.7)
    assert np.all(two.cells[one.cells < UNKNOWN] >= 0)


def test_behind_an_obstacle_it_stays_unknown_and_before_it_is_free() -> None:
    costs = a_map((5.1, 0.1))
    assert at(costs, 2.0, 0.1) == 0
    assert at(costs, 9.0, 0.15) == UNKNOWN
    assert at(costs, 9.0, 3.0) == 0


def test_beyond_the_range_nothing_is_known() -> None:
    costs = a_map()
    assert at(costs, 23.5, 0.0) == 0
    assert at(costs, -24.5, 0.0) == UNKNOWN


def test_whoever_has_gone_is_cleared_by_the_next_scan() -> None:
    before = a_map((5.1, 0.1))
    assert at(a_map(before=before), 5.1, 0.1) == 0


def test_who_is_hidden_by_another_is_not_forgotten() -> None:
    before = a_map((9.1, 0.1))
    assert at(a_map((5.1, 0.1), before=before), 9.1, 0.1) == OBSTACLE


@pytest.mark.parametrize(("columns", "rows"), [(3, 0), (-7, 2), (0, -250), (260, 5), (100, -249)])
def test_rolling_moves_what_is_known_and_brings_in_the_unknown(columns: int, rows: int) -> None:
    rng = np.random.default_rng(1)
    cells = rng.integers(0, 256, (SIDE, SIDE)).astype(np.uint8)
    out = rolled(cells, columns, rows)
    padded = np.full((3 * SIDE, 3 * SIDE), UNKNOWN, np.uint8)
    padded[SIDE : 2 * SIDE, SIDE : 2 * SIDE] = cells
    first_row, first_column = min(SIDE + rows, 2 * SIDE), min(SIDE + columns, 2 * SIDE)
    wanted = padded[first_row : first_row + SIDE, first_column : first_column + SIDE]
    assert np.array_equal(out, wanted)


def test_the_map_moves_with_the_vehicle_and_obstacles_stay_where_they_are() -> None:
    costs = a_map((5.1, 0.1))
    moved = RULES.updated(costs, 2.0, 0.0, np.array([2.0, 0.0]), np.array([[5.1, 0.1]]))
    assert moved.column == costs.column + 10
    assert at(moved, 5.1, 0.1) == OBSTACLE
    assert obstacle_cells(moved.cells, moved.column, moved.row, 2.0, 0.0, 8.0) == pytest.approx(
        np.array([[5.1, 0.1]])
    )


def straight(length_m: float = 6.0) -> np.ndarray:
    x = np.arange(0.0, length_m, CELL_M)
    return np.column_stack((x, np.zeros_like(x), np.zeros_like(x)))


def mean_cost(costs: CostMap, unknown: float = 0.5) -> float:
    return float(ahead_of(costs.cells, costs.column, costs.row, straight(), 2.0, 0.8, unknown))


def test_mean_cost_is_normalized_and_grows_with_what_is_nearer_to_the_way() -> None:
    free, beside, on_it = a_map(), a_map((5.0, 1.6)), a_map((5.0, 0.1))
    assert mean_cost(free) == 0.0
    assert 0.0 < mean_cost(beside, 0.0) < mean_cost(on_it, 0.0) < 0.5
    assert mean_cost(RULES.empty()) == 0.5


def test_speeds_fall_exponentially_from_the_limit() -> None:
    speeds = SafeSpeeds()
    assert speeds.by_steering(0.0).speed_mps == 2.0
    assert speeds.by_steering(-0.5).speed_mps == speeds.by_steering(0.5).speed_mps
    assert speeds.by_steering(0.4).speed_mps == pytest.approx(speeds.by_steering(0.2).speed_mps ** 2 / 2.0)
    assert speeds.by_cost(0.0).speed_mps == 2.0
    assert speeds.by_cost(0.15).speed_mps == pytest.approx(2.0 / math.e)


@pytest.mark.parametrize("steer_rad", [0.1, 0.2, 0.3, 0.4, 0.51])
def test_the_speed_by_steering_keeps_the_comfortable_lateral_acceleration(steer_rad: float) -> None:
    radius_m = 1.65 / math.tan(steer_rad)
    assert SafeSpeeds().by_steering(steer_rad).speed_mps ** 2 / radius_m <= 0.5


def test_a_crossings_ground_is_told_seen_and_taken() -> None:
    outline = np.array([[4.0, -2.0], [6.0, -2.0], [6.0, 2.0], [4.0, 2.0]])
    costs = a_map()
    assert seen_in(costs.cells, costs.column, costs.row, outline) == (1.0, 0)
    costs = a_map((5.0, 1.0))
    known, taken = seen_in(costs.cells, costs.column, costs.row, outline)
    assert taken == 1
    assert known > 0.9
    costs = a_map(*((2.1, 0.1 * k) for k in range(-40, 41)))
    known, taken = seen_in(costs.cells, costs.column, costs.row, outline)
    assert (known, taken) == (0.0, 0)
