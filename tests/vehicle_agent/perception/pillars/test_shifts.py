"""How far a body moved between two turns is told by its returns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.perception.pillars.shifts import shifts_of
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

SIZES_M = {PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.75, 0.6), VEHICLE: (4.4, 1.8)}


def corner(kind: int, yaw: float, rng: np.random.Generator) -> np.ndarray:
    """(n, 2) returns of two sides of a body, about its middle."""
    length, width = SIZES_M[kind]
    along = np.column_stack((rng.uniform(-0.5, 0.5, 60) * length, np.full(60, -0.5 * width)))
    across = np.column_stack((np.full(30, -0.5 * length), rng.uniform(-0.5, 0.5, 30) * width))
    points = np.concatenate((along, across)) + rng.normal(0.0, 0.01, (90, 2))
    return points @ np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])


@given(
    kind=st.sampled_from((PEDESTRIAN, CYCLIST, VEHICLE)), yaw=st.floats(-3.1, 3.1), seed=st.integers(0, 999),
    way_m=st.floats(-0.6, 0.6), place=st.tuples(st.floats(-10.0, 30.0), st.floats(-15.0, 15.0)),
)  # fmt: skip
@settings(max_examples=60)
def test_a_body_that_moves_along_its_yaw(
    kind: int, yaw: float, seed: int, way_m: float, place: tuple[float, float]
) -> None:
    rng = np.random.default_rng(seed)
    moved = way_m * np.array([np.cos(yaw), np.sin(yaw)])
    newer = corner(kind, yaw, rng) + place
    older = corner(kind, yaw, rng) + place - moved
    points = np.concatenate((newer, older)).astype(np.float32)
    is_older = np.arange(len(points)) >= len(newer)
    box = np.array([[*place, yaw, *SIZES_M[kind]]])
    assert shifts_of(np.array([kind]), box, points, is_older)[0] == pytest.approx(moved, abs=0.12)


def test_a_wall_that_shows_no_motion_stands() -> None:
    wall = np.column_stack((np.linspace(-12.0, 12.0, 400), np.full(400, 1.0)))
    points = np.concatenate((wall, wall)).astype(np.float32)
    is_older = np.arange(800) >= 400
    box = np.array([[0.0, 1.0, 0.0, 4.4, 1.8]])
    assert np.abs(shifts_of(np.array([VEHICLE]), box, points, is_older)).max() < 0.05


def test_too_few_returns_give_no_shift() -> None:
    points = np.array([[5.0, 0.0], [5.1, 0.0], [5.0, 0.1], [5.1, 0.1]], dtype=np.float32)
    box = np.array([[5.0, 0.0, 0.0, 0.5, 0.5]])
    newer_only = np.zeros(4, dtype=bool)
    assert np.isnan(shifts_of(np.array([PEDESTRIAN]), box, points, newer_only)).all()
    assert np.isnan(shifts_of(np.array([PEDESTRIAN]), box, points, ~newer_only)).all()
