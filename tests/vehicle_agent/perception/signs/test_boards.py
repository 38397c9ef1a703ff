"""The five stages on one scan: which reflecting things are boards."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.vehicle_agent.perception.signs.boards_in_scans import (
    LIDAR_Z_M,
    octagon,
    plate,
    point_down,
    returns_of,
    scan_of,
)
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.signs.stages import SignStages, without_outliers
from vehicle_agent.signals import SignPercept

FINDER = SignFinder(SignStages(z_m=LIDAR_Z_M))


def seen(*bright: np.ndarray) -> SignPercept:
    return FINDER.percept(*scan_of(*bright), 7)


@given(
    st.floats(5.0, 25.0),
    st.floats(-4.5, 4.5),
    st.floats(2.15, 2.7),
    st.floats(-0.25, 0.25),
    st.integers(1, 99),
)
def test_a_board_that_faces_the_vehicle_is_found_where_it_stands(
    x_m: float, y_m: float, z_m: float, turned_rad: float, seed: int
) -> None:
    returns = returns_of(octagon(), (x_m, y_m, z_m), turned_rad, seed=seed)
    if len(returns) < 8:
        return
    percept = seen(returns)
    assert percept.boards_base.shape == (1, 6)
    assert np.hypot(*(percept.boards_base[0, :2] - [x_m, y_m])) < 0.25
    assert abs(math.remainder(percept.boards_base[0, 3] - turned_rad - math.pi, 2.0 * math.pi)) < 0.45


def test_several_signs_are_found_at_once_nearest_first() -> None:
    percept = seen(returns_of(octagon(), (18.0, -3.5, 2.5)), returns_of(point_down(), (9.0, 3.5, 2.5)))
    assert np.allclose(percept.boards_base[:, 0], (9.0, 18.0), atol=0.2)
    assert set(percept.owners.tolist()) == {0, 1}


@pytest.mark.parametrize(
    ("outline", "middle"),
    [
        (plate(0.5, 0.11), (8.0, 2.0, 0.5)),  # of a parked car
        (plate(1.8, 0.25), (9.0, -3.0, 0.88)),  # a barrier of a building site
        (plate(1.8, 0.3), (9.0, -3.0, 2.3)),  # too wide for a sign
        (plate(0.12, 0.12), (7.0, -2.5, 0.85)),  # the band of a bollard
        (octagon(), (45.0, -3.0, 2.5)),  # beyond the field
        (octagon(), (10.0, -12.0, 2.5)),  # a road aside
    ],
)
def test_what_is_too_low_too_wide_or_outside_the_field_is_no_board(
    outline: np.ndarray, middle: tuple[float, float, float]
) -> None:
    assert len(seen(returns_of(outline, middle)).boards_base) == 0


def test_a_board_that_faces_another_way_is_left_out() -> None:
    assert len(seen(returns_of(octagon(), (9.0, 0.0, 2.5), math.radians(50.0))).boards_base) == 0


def test_a_surface_in_several_planes_is_left_out() -> None:
    rng = np.random.default_rng(3)
    heap = (np.array([9.0, -3.0, 2.4]) + rng.uniform(-0.4, 0.4, (60, 3))).astype(np.float32)
    assert len(seen(heap).boards_base) == 0


def test_radius_outliers_go_until_every_point_has_company() -> None:
    board = returns_of(octagon(), (9.0, 0.0, 2.5)).astype(np.float64)
    # A chain of points, each of which has only the one before within the radius.
    chain = np.array([[9.0, 0.8 + 0.3 * k, 2.5] for k in range(5)])
    kept = without_outliers(np.vstack((board, chain)), FINDER.stages)
    assert len(kept) == pytest.approx(len(board), abs=2)
    assert kept[:, 1].max() < 0.9


def test_a_post_before_the_board_does_not_make_it_narrow() -> None:
    board = returns_of(octagon(), (9.0, 0.0, 2.5))
    # A branch hides the right half: the ends that are left there are not the board's edges.
    kept = board[board[:, 1] > -0.05]
    rings = np.unique(np.round(board[:, 2], 1))
    branch = np.array(
        [
            [4.5, -(0.1 + 0.01 * k) * 0.5, LIDAR_Z_M + (z - LIDAR_Z_M) * 0.5]
            for z in rings
            for k in range(-4, 25)
        ],
        np.float32,
    )
    points, intensities = scan_of(kept)
    free = FINDER.percept(points, intensities, 1)
    hidden = FINDER.percept(
        np.vstack((points, branch)), np.append(intensities, np.full(len(branch), 30.0)), 1
    )
    assert len(free.chords)
    assert not len(hidden.chords)
    assert len(hidden.boards_base) == 1


@pytest.mark.parametrize("dark", [np.float32(np.nan), np.float32(0.0), np.float32(100.0)])
def test_dark_or_unknown_returns_are_nothing(dark: np.float32) -> None:
    points, intensities = scan_of(returns_of(octagon(), (9.0, 0.0, 2.5)))
    intensities[:] = dark
    assert len(FINDER.percept(points, intensities, 1).boards_base) == 0


def test_returns_without_a_place_are_left_out() -> None:
    points, intensities = scan_of(
        returns_of(octagon(), (9.0, 0.0, 2.5)), np.full((40, 3), np.nan, np.float32)
    )
    assert len(FINDER.percept(points, intensities, 1).boards_base) == 1


def test_an_empty_scan_has_no_boards_and_another_shape_is_refused() -> None:
    assert len(FINDER.percept(np.empty((0, 3), np.float32), np.empty(0, np.float32), 1).boards_base) == 0
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        FINDER.percept(np.zeros((4, 4), np.float32), np.zeros(4, np.float32), 1)
    with pytest.raises(ValueError, match=r"\(n,\)"):
        FINDER.percept(np.zeros((4, 3), np.float32), np.zeros(3, np.float32), 1)


def test_the_same_scan_gives_the_same_percept() -> None:
    scan = scan_of(returns_of(octagon(), (12.0, -3.0, 2.5)))
    first, second = (FINDER.percept(*scan, 1) for _ in range(2))
    assert first.boards_base.tobytes() == second.boards_base.tobytes()
    assert first.chords.tobytes() == second.chords.tobytes()
