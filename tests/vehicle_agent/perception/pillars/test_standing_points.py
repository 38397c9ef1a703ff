"""Only what stands above the ground near it goes to the detector."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.perception.pillars.standing_points import standing_points

OWN = (-1.0, 3.6, 0.9)


def ground(slope: float, reach_m: float = 30.0) -> np.ndarray:
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.arange(-reach_m, reach_m, 0.7)] * 2))
    return np.column_stack((x, y, slope * x)).astype(np.float32)


def post(x: float, y: float, slope: float) -> np.ndarray:
    heights = np.linspace(0.3, 1.7, 8)
    return np.column_stack((np.full(8, x), np.full(8, y), slope * x + heights)).astype(np.float32)


@given(
    slope=st.floats(-0.03, 0.03), x=st.floats(6.0, 25.0), y=st.floats(-25.0, 25.0)
)  # fmt: skip
def test_a_post_stands_on_a_slope_and_the_slope_does_not(slope: float, x: float, y: float) -> None:
    road = ground(slope)
    points = np.concatenate((road, post(x, y, slope)))
    rows, heights = standing_points(points, OWN)
    found = rows >= len(road)
    assert found.sum() >= 6
    assert heights[found].max() == pytest.approx(1.7, abs=0.25)
    # The slope itself rises by at most its grade over the 6 m within which the ground is looked for.
    assert (heights[~found] < 0.03 * 6.0 + 0.05).all()


def test_own_body_branches_and_what_is_no_number_are_left_out() -> None:
    points = np.array(
        [[1.0, 0.5, 1.0], [8.0, 0.0, 4.0], [np.nan, 0.0, 1.0], [9.0, 0.0, np.inf], [10.0, 2.0, 0.8]],
        dtype=np.float32,
    )
    rows, _ = standing_points(np.concatenate((ground(0.0), points)), OWN)
    assert rows.tolist() == [len(ground(0.0)) + 4]


def test_an_empty_scan_has_nothing_that_stands() -> None:
    rows, heights = standing_points(np.empty((0, 3), dtype=np.float32), OWN)
    assert len(rows) == len(heights) == 0


def test_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        standing_points(np.empty((4, 2), dtype=np.float32), OWN)
