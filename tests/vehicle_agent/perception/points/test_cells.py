"""Obstacle cells: what must stop the shuttle, and what must not."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.vehicle_agent.perception.points.bodies import GRID_ARGUMENTS, person, pillar, road, scan, sides
from tests.vehicle_agent.perception.test_height_map import a_scan
from vehicle_agent.perception.points.cells import percept_from_points, point_heights
from vehicle_agent.perception.points.grid import PointGrid

GRID = PointGrid(*GRID_ARGUMENTS)


def cells_of(points: np.ndarray) -> np.ndarray:
    return percept_from_points(points, 1, GRID).cells_base


@pytest.mark.parametrize("slope", [0.0, 0.1, -0.1])
def test_a_road_is_free_level_or_sloping(slope: float) -> None:
    assert len(cells_of(scan(road(slope)))) == 0
    assert len(cells_of(a_scan([], 0.5 * slope))) == 0


@pytest.mark.parametrize("kerb_m", [0.08, 0.12, 0.16])
def test_a_kerb_is_no_obstacle(kerb_m: float) -> None:
    assert len(cells_of(scan(road(kerb_y_m=3.0, kerb_m=kerb_m)))) == 0


def test_what_lies_on_the_road_is_an_obstacle() -> None:
    lying = sides(9.0, 1.0, 0.4, 1.7, 0.45, 0.02, 0.3)
    top = lying.copy()
    top[:, 2] = 0.28
    cells = cells_of(scan(road(), lying, top))
    assert len(cells) > 3
    assert np.hypot(cells[:, 0] - 9.0, cells[:, 1] - 1.0).max() < 1.3


def test_a_lying_person_on_a_pavement_is_an_obstacle_too() -> None:
    lying = sides(9.0, 4.0, 0.0, 1.7, 0.45, 0.14, 0.45)
    assert len(cells_of(scan(road(kerb_y_m=3.0), lying))) > 3


def test_branches_above_the_vehicle_are_none_also_on_a_slope() -> None:
    for slope in (0.0, 0.1):
        branches = np.column_stack((np.repeat(np.arange(8.0, 14.0, 0.2), 5), np.tile(np.arange(5) * 0.2, 30)))
        crown = np.column_stack((branches, 2.6 + slope * branches[:, 0]))
        assert len(cells_of(scan(road(slope), crown))) == 0


def test_reflections_below_the_road_neither_hide_nor_make_an_obstacle() -> None:
    mirrored = pillar(10.0, 2.0, 0.3, -1.8, -0.2)
    assert len(cells_of(scan(road(), mirrored))) == 0
    cells = cells_of(scan(road(), mirrored, person(10.0, -2.0)))
    assert len(cells) > 0
    assert np.abs(cells[:, 1] + 2.0).max() < 0.6


def test_the_vehicle_itself_is_none_nor_what_of_it_trails_behind() -> None:
    assert len(cells_of(scan(road(), np.array([[1.0, 0.5, 1.0]] * 9), np.array([[-1.1, 0.5, 1.5]] * 9)))) == 0


def test_dust_of_single_returns_is_none() -> None:
    assert len(cells_of(scan(road(), np.array([[8.0, 0.0, 1.0], [10.0, 3.0, 0.7]])))) == 0


@settings(max_examples=25, deadline=None)
@given(
    slope=st.floats(-0.05, 0.05), apart=st.floats(6.0, 20.0), bearing=st.floats(-0.5, 0.5),
    height=st.floats(1.3, 1.9),
)  # fmt: skip
def test_a_person_is_found_on_a_slope_and_nothing_else(
    slope: float, apart: float, bearing: float, height: float
) -> None:
    """Nearer or smaller ones downhill are below the lowest ring of the lidar on the roof."""
    x, y = 3.2 + apart * math.cos(bearing), apart * math.sin(bearing)
    cells = cells_of(a_scan([(x, y, 0.5, height)], slope))
    away = np.hypot(cells[:, 0] - x, cells[:, 1] - y)
    assert len(away) > 0
    assert away.max() < 0.7


def test_heights_are_those_above_the_ground_below() -> None:
    points = scan(road(0.08), person(12.0, 2.0) + np.array([0.0, 0.0, 0.96]), noise_m=0.0)
    heights = point_heights(points, GRID)
    assert heights.heights_m[-1] == pytest.approx(points[-1, 2] - 0.08 * 12.0, abs=0.06)
    assert heights.used == np.count_nonzero(heights.cell_of >= 0)


def test_points_that_are_no_numbers_change_nothing() -> None:
    points = scan(road(), person(9.0, 1.0))
    broken = np.vstack((points, np.full((5, 3), np.nan), [[np.inf, 0.0, 0.0]])).astype(np.float32)
    assert cells_of(broken).tolist() == cells_of(points).tolist()


def test_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        percept_from_points(np.zeros((4, 2), np.float32), 1, GRID)
