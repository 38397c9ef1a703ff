"""Kerbs in points: where the ground has a step, and nowhere else."""

import numpy as np
import pytest

from contract.geometry import Array
from vehicle_agent.perception.points.cells import percept_from_points
from vehicle_agent.perception.points.grid import PointGrid

GRID = PointGrid(2.4, 3.5, 0.85, 0.82)
# Of heights: 3 cm along a beam that comes down at 20 degrees.
NOISE_M = 0.01
EDGE_M = 2.6


def ground(kerb_m: float, slope: float = 0.0) -> Array:
    """(n, 3) a road with kerbs on both sides, seen by rings 0.35 m apart."""
    x, y = np.meshgrid(np.arange(-8.0, 14.0, 0.35), np.arange(-8.0, 8.0, 0.04))
    rng = np.random.default_rng(1)
    z = slope * x + np.where(np.abs(y) > EDGE_M, kerb_m, 0.0) + rng.normal(0.0, NOISE_M, x.shape)
    return np.column_stack((x.ravel(), y.ravel(), z.ravel()))


def kerbs(points: Array) -> Array:
    return percept_from_points(points.astype(np.float32), 1, GRID).kerbs_base


def standing(x_m: float, y_m: float) -> Array:
    """(n, 3) a person."""
    angle, z = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 24), np.arange(0.05, 1.7, 0.05))
    return np.column_stack((x_m + 0.2 * np.cos(angle.ravel()), y_m + 0.2 * np.sin(angle.ravel()), z.ravel()))


@pytest.mark.parametrize("kerb_m", [0.1, 0.12, 0.16])
@pytest.mark.parametrize("slope", [0.0, 0.06, -0.06])
def test_a_kerb_is_seen_where_it_is(kerb_m: float, slope: float) -> None:
    found = kerbs(ground(kerb_m, slope))
    near = found[np.abs(found[:, 0]) < 8.0]
    assert np.abs(np.abs(near[:, 1]) - EDGE_M).max() < 0.3
    for side in (-1.0, 1.0):
        at = near[side * near[:, 1] > 0.0, 0]
        assert np.diff(np.sort(at)).max() < 1.0, "without gaps"


@pytest.mark.parametrize("slope", [0.0, 0.1, -0.1])
def test_a_road_without_kerbs_has_none(slope: float) -> None:
    assert len(kerbs(ground(0.0, slope))) == 0


def test_a_kerb_that_is_lowered_at_a_crossing_is_none() -> None:
    assert len(kerbs(ground(0.02))) == 0


def test_the_feet_of_a_person_and_the_foot_of_a_wall_are_no_kerbs() -> None:
    x, z = np.meshgrid(np.arange(-6.0, 12.0, 0.1), np.arange(0.05, 2.0, 0.1))
    wall = np.column_stack((x.ravel(), np.full(x.size, 4.0), z.ravel()))
    scene = np.vstack((ground(0.0), standing(7.0, 0.0), standing(6.0, -2.0), wall))
    assert len(kerbs(scene)) == 0


def test_a_scan_of_nothing_has_no_kerbs() -> None:
    assert kerbs(np.empty((0, 3))).shape == (0, 2)
