"""The gate's own look ahead of the bumper."""

import math

import numpy as np

from vehicle_agent.runtime.gate_footprint import distance_on_arc


def test_on_a_curve_it_looks_along_the_arc() -> None:
    left, right = np.array([[6.0, 3.0]]), np.array([[6.0, -3.0]])
    assert distance_on_arc(left, 0.15, 3.5, 0.9, 10.0) < 4.0
    assert math.isinf(distance_on_arc(right, 0.15, 3.5, 0.9, 10.0))
    assert distance_on_arc(right, -0.15, 3.5, 0.9, 10.0) < 4.0
    assert distance_on_arc(np.array([[5.0, 0.0]]), 0.0, 3.5, 0.9, 10.0) == 1.5


def test_what_is_beside_or_behind_the_bumper_is_not_ahead_of_it() -> None:
    beside = np.array([[1.0, 1.0], [-2.0, 0.0], [3.0, -0.5]])
    assert math.isinf(distance_on_arc(beside, 0.0, 3.5, 0.9, 10.0))
