"""Beams become things: one for a pair of legs, one for a wall."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.perception.laser_people.segments import SegmentParams, clusters_of

ANGLES = np.radians(0.25) * (np.arange(720) - 359.5)
PARAMS = SegmentParams()


def scan_of(discs: list[tuple[float, float, float]], wall_x_m: float = math.inf) -> np.ndarray:
    """Ranges to discs (x, y, radius) and to a wall across."""
    ranges = np.full(len(ANGLES), np.inf)
    ahead = np.cos(ANGLES) > 1e-3
    if math.isfinite(wall_x_m):
        ranges[ahead] = wall_x_m / np.cos(ANGLES[ahead])
    for x, y, radius in discs:
        along = x * np.cos(ANGLES) + y * np.sin(ANGLES)
        across = np.abs(-x * np.sin(ANGLES) + y * np.cos(ANGLES))
        meets = (across < radius) & (along > 0.0)
        reach = along - np.sqrt(np.maximum(radius**2 - across**2, 0.0))
        ranges = np.where(meets, np.minimum(ranges, reach), ranges)
    return ranges


@given(st.floats(3.0, 30.0), st.floats(-1.2, 1.2), st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_a_person_is_one_thing_whose_middle_is_found(range_m: float, angle: float, seed: int) -> None:
    place = np.array([range_m * math.cos(angle), range_m * math.sin(angle)])
    ranges = scan_of([(place[0], place[1], 0.2)])
    noisy = ranges + np.random.default_rng(seed).normal(0.0, 0.012, len(ranges))
    clusters = clusters_of(noisy, ANGLES, PARAMS)
    assert len(clusters) == 1
    assert np.hypot(*(clusters.centres_laser[0] - place)) < 0.15
    assert clusters.widths_m[0] < 0.5


@given(st.floats(3.0, 12.0), st.floats(0.2, 0.4))
@settings(max_examples=40, deadline=None)
def test_two_legs_are_one_thing_and_two_people_are_two(range_m: float, stride_m: float) -> None:
    legs = scan_of([(range_m, 0.5 * stride_m, 0.07), (range_m + 0.1, -0.5 * stride_m, 0.07)])
    assert len(clusters_of(legs, ANGLES, PARAMS)) == 1
    people = scan_of([(range_m, 0.6, 0.2), (range_m, -0.6, 0.2)])
    assert len(clusters_of(people, ANGLES, PARAMS)) == 2


def test_a_wall_is_wide_and_stays_one_behind_a_person() -> None:
    clusters = clusters_of(scan_of([(8.0, 0.0, 0.2)], wall_x_m=12.0), ANGLES, PARAMS)
    small = clusters.widths_m < 1.0
    # Where the laser looks along the wall, its beams lie metres apart.
    ahead = np.abs(clusters.centres_laser[:, 1]) < 20.0
    assert (small & ahead).sum() == 1
    assert clusters.widths_m[~small].min() > 10.0


def test_what_adjoins_another_thing_or_is_partly_hidden_is_not_free() -> None:
    alone = clusters_of(scan_of([(8.0, 0.0, 0.2)], wall_x_m=12.0), ANGLES, PARAMS)
    (person,) = np.flatnonzero((alone.widths_m < 1.0) & (np.abs(alone.centres_laser[:, 1]) < 5.0))
    assert alone.is_free[person]
    # A twig beside a twig, 0.45 m apart, and a person behind a post.
    hedge = clusters_of(scan_of([(8.0, 0.0, 0.03), (8.0, 0.48, 0.03)]), ANGLES, PARAMS)
    assert hedge.is_free.tolist() == [False, False]
    hidden = clusters_of(scan_of([(8.0, 0.0, 0.2), (5.0, 0.1, 0.05)]), ANGLES, PARAMS)
    ranges = np.hypot(*hidden.centres_laser.T)
    assert not hidden.is_free[ranges > 7.0].any()
    assert hidden.is_free[ranges < 6.0].all(), "the post itself is seen whole"


def test_readings_that_are_no_returns_are_nothing() -> None:
    for value in (math.nan, math.inf, 0.0, -1.0, 1e6):
        assert len(clusters_of(np.full(len(ANGLES), value), ANGLES, PARAMS)) == 0
    assert len(clusters_of(np.empty(0), np.empty(0), PARAMS)) == 0
