"""Cells within a track's outline are the track's, all others stay."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2, inverse, transform_points
from vehicle_agent.perception.own_cells import outside_tracks

MARGIN_M = 0.3


def test_every_cell_is_compared_with_every_track() -> None:
    poses = np.array([[10.0, 0.0, 0.0], [10.0, 10.0, math.pi / 2], [-10.0, 0.0, 0.0], [0.0, -10.0, 0.0]])
    sizes = np.array([[4.0, 2.0]] * 4)
    cells = np.array(
        [[12.2, 0.0], [12.4, 0.0], [10.0, 12.2], [12.2, 10.0], [-10.0, 1.2], [0.0, -11.4], [0.0, -11.2]]
    )
    assert outside_tracks(cells, poses, sizes, MARGIN_M).tolist() == [
        False, True, False, True, False, True, False
    ]  # fmt: skip


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.floats(-math.pi, math.pi), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_an_outline_turns_with_its_track(x_m: float, y_m: float, yaw_rad: float, seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-25.0, 25.0, (30, 2))
    ahead, aside = transform_points(inverse(Pose2(x_m, y_m, yaw_rad)), points).T
    expected = (np.abs(ahead) > 2.0 + MARGIN_M) | (np.abs(aside) > 1.0 + MARGIN_M)
    found = outside_tracks(points, np.array([[x_m, y_m, yaw_rad]]), np.array([[4.0, 2.0]]), MARGIN_M)
    assert found.tolist() == expected.tolist()
