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
