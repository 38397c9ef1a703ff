"""The map's drivable area, and the kerbs that the vehicle sees in it."""

import numpy as np

from contract.geometry import Array
from vehicle_agent.planning.motion.seen_kerbs import narrowed
from vehicle_agent.signals import Corridor

KEEP_M = 1.0


def straight(left_m: float = 3.0, right_m: float = 3.0, yaw_rad: float = 0.6) -> Corridor:
    s = np.arange(0.0, 40.5, 0.5)
    n = len(s)
    heading = np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
    return Corridor(
        s, np.array([100.0, -40.0]) + s[:, None] * heading, np.full(n, yaw_rad), np.zeros(n), np.full(n, 4.0),
        np.full(n, left_m), np.full(n, right_m), np.zeros(n, np.int64),
    )  # fmt: skip


def beside(corridor: Corridor, s: Array, aside_m: Array | float) -> Array:
    """(k, 2) places along the line and to its left, map frame."""
    yaw = corridor.yaw_rad[0]
    along, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    return corridor.points_map[0] + s[:, None] * along + np.broadcast_to(aside_m, s.shape)[:, None] * left


def test_a_kerb_that_the_map_does_not_know_is_the_edge() -> None:
    corridor = straight()
    kerb = beside(corridor, np.arange(10.0, 20.0, 0.25), 1.8)
    found = narrowed(corridor, kerb, KEEP_M)
    inside = (corridor.s_m >= 10.5) & (corridor.s_m <= 19.0)
    np.testing.assert_allclose(found.left_m[inside], 1.8, atol=1e-6)
    np.testing.assert_array_equal(found.right_m, corridor.right_m)
    apart = (corridor.s_m < 8.5) | (corridor.s_m > 21.5)
    np.testing.assert_array_equal(found.left_m[apart], corridor.left_m[apart])
    right = narrowed(corridor, beside(corridor, np.arange(10.0, 20.0, 0.25), -2.1), KEEP_M)
    np.testing.assert_allclose(right.right_m[inside], 2.1, atol=1e-6)


def test_a_kerb_beyond_the_edge_of_the_map_changes_nothing() -> None:
    corridor = straight(left_m=1.75)
    found = narrowed(corridor, beside(corridor, np.arange(5.0, 30.0, 0.25), 2.4), KEEP_M)
    np.testing.assert_array_equal(found.left_m, corridor.left_m)


def test_a_speed_bump_across_the_lane_is_driven_over() -> None:
    corridor = straight()
    across = beside(corridor, np.full(17, 15.0), np.linspace(-2.9, 2.9, 17))
    found = narrowed(corridor, across, KEEP_M)
    assert found.left_m.min() > KEEP_M
    assert found.right_m.min() > KEEP_M


def test_a_single_step_is_a_stone() -> None:
    corridor = straight()
    found = narrowed(corridor, beside(corridor, np.array([15.0, 25.0]), 1.5), KEEP_M)
    np.testing.assert_array_equal(found.left_m, corridor.left_m)


def test_without_kerbs_and_without_a_line_nothing_is_done() -> None:
    corridor = straight()
    assert narrowed(corridor, np.empty((0, 2)), KEEP_M) is corridor
    far = np.array([[0.0, 0.0]] * 5)
    assert narrowed(corridor, far, KEEP_M) is corridor
