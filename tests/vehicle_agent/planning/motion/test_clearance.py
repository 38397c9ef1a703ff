"""Clearances are exact."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.planning.motion.clearance import Box, first_touch, pose_clearance

BOX = Box(3.5, 0.85, 0.815)


def outline(x: float, y: float, yaw: float) -> shapely.Polygon:
    corners = [(3.5, 0.815), (3.5, -0.815), (-0.85, -0.815), (-0.85, 0.815)]
    cos, sin = math.cos(yaw), math.sin(yaw)
    return shapely.Polygon([(x + cos * u - sin * v, y + sin * u + cos * v) for u, v in corners])


@settings(max_examples=100, deadline=None)
@given(
    yaw=st.floats(-4.0, 4.0), px=st.floats(-8.0, 8.0), py=st.floats(-8.0, 8.0), radius=st.floats(0.05, 1.0)
)
def test_one_clearance_agrees_with_shapely(yaw: float, px: float, py: float, radius: float) -> None:
    body = outline(1.0, -2.0, yaw)
    point = shapely.Point(px, py)
    signed = -body.exterior.distance(point) if body.contains(point) else body.distance(point)
    discs = np.array([[px, py, radius]])
    got = pose_clearance(np.array((1.0, -2.0, yaw)), BOX, discs, 50.0)
    assert got == pytest.approx(signed - radius, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), cap_m=st.sampled_from([0.3, 2.0, 50.0]))
def test_of_many_discs_the_nearest_counts_up_to_the_cap(seed: int, cap_m: float) -> None:
    rng = np.random.default_rng(seed)
    discs = np.column_stack((rng.uniform(-7.0, 9.0, (12, 2)), rng.uniform(0.1, 0.6, 12)))
    pose = np.array((0.5, -0.5, rng.uniform(-3.0, 3.0)))
    each = [pose_clearance(pose, BOX, discs[[k]], 50.0) for k in range(len(discs))]
    assert pose_clearance(pose, BOX, discs, cap_m) == pytest.approx(min([cap_m, *each]), abs=1e-12)


def test_a_disc_before_the_bumper_or_at_a_corner_is_near_for_a_short_cap() -> None:
    """Far from the body's middle and still within the cap."""
    for x_m, y_m in ((3.5 + 0.4, 0.0), (3.5 + 0.3, 0.815 + 0.3), (-0.85 - 0.3, -0.815 - 0.3)):
        assert pose_clearance(np.zeros(3), BOX, np.array([[x_m, y_m, 0.25]]), 0.3) < 0.3


def test_without_discs_nothing_is_touched() -> None:
    assert first_touch(np.zeros((2, 3)), BOX, np.empty((0, 3)), 0.5) == (-1, False)


def test_the_first_pose_that_touches_ends_the_way() -> None:
    poses = np.column_stack((0.25 * np.arange(40), np.zeros(40), np.zeros(40)))
    at, touching = first_touch(poses, BOX, np.array([[8.0, 0.0, 0.25]]), 0.1)
    assert not touching
    assert poses[at, 0] == 4.25


def test_what_stands_at_the_flank_or_behind_does_not_keep_the_vehicle() -> None:
    ahead = np.column_stack((0.25 * np.arange(8), np.zeros(8), np.zeros(8)))
    flank, behind = [1.5, 0.815 + 0.25 + 0.05, 0.25], [-1.05, 0.3, 0.25]
    assert first_touch(ahead, BOX, np.array([flank, behind]), 0.1) == (-1, False)
    # but it is not driven towards, and what is ahead keeps its whole margin
    turning = ahead + np.column_stack((np.zeros(8), 0.02 * np.arange(8), np.zeros(8)))
    assert first_touch(turning, BOX, np.array([flank]), 0.1)[0] > 0
    near = [4.6, 0.815 + 0.25 + 0.05, 0.25]
    assert first_touch(ahead, BOX, np.array([flank, behind, near]), 0.1)[0] > 0


def test_somebody_inside_the_outline_touches() -> None:
    assert first_touch(np.zeros((2, 3)), BOX, np.array([[3.6, 0.0, 0.25]]), 0.1) == (-1, True)
