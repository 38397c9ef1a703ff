"""The Frenet frame is exact both ways on straight and curved lines."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.vehicle_agent.planning.motion.scenes import a_corridor
from vehicle_agent.planning.motion.path.frame import (
    LineFolds,
    fit_line,
    offset_from_pose,
    pose_from_offset,
    project_on,
)
from vehicle_agent.planning.motion.path.gp_path import SolvedPath
from vehicle_agent.planning.motion.path.path_samples import poses_at, sample_path


@settings(max_examples=60, deadline=None)
@given(
    curvature=st.floats(-0.12, 0.12),
    s_m=st.floats(2.0, 45.0),
    l0=st.floats(-3.0, 3.0),
    l1=st.floats(-1.5, 1.5),
    l2=st.floats(-0.2, 0.2),
)
def test_offsets_and_poses_are_each_others_inverse(
    curvature: float, s_m: float, l0: float, l1: float, l2: float
) -> None:
    corridor = a_corridor(curvature)
    line = fit_line(corridor.s_m, corridor.points_map, 0.6)
    frame = line.frames(np.array([s_m]))[0]
    x, y, yaw, kappa = pose_from_offset(frame, l0, l1, l2)
    s_again = project_on(line.control_map, line.first_m, line.step_m, x, y, s_m - 2.0, s_m + 2.0)
    again = offset_from_pose(line.frames(np.array([s_again]))[0], x, y, yaw, kappa)
    assert s_again == pytest.approx(s_m, abs=1e-9)
    assert again == pytest.approx((l0, l1, l2), abs=1e-8)


def test_the_frame_lies_on_a_polyline_of_chords_without_its_corners() -> None:
    corridor = a_corridor(0.1)
    turn = 0.1 * np.arange(0, 50)  # chords of a metre, sampled each half metre
    vertices = np.column_stack([10.0 * np.sin(turn), 10.0 * (1.0 - np.cos(turn))])
    s = np.arange(0.0, 48.0, 0.5)
    points = np.column_stack([np.interp(s, np.arange(50), vertices[:, i]) for i in range(2)])
    line = fit_line(s, points, 0.6)
    frames = line.frames(np.linspace(5.0, 40.0, 300))
    off_m = np.abs(np.hypot(frames[:, 0], frames[:, 1] - 10.0) - 10.0)
    assert off_m.max() < 0.03
    assert np.abs(frames[:, 5] - 0.1).max() < 0.01
    assert corridor.s_m[0] == -5.0


def test_curvature_of_a_path_is_the_turn_of_its_yaw_by_its_way() -> None:
    corridor = a_corridor(0.08)
    line = fit_line(corridor.s_m, corridor.points_map, 0.6)
    states = np.array([[0.3 * math.sin(0.7 * i), 0.1 * math.cos(i), 0.02] for i in range(20)])
    path = SolvedPath(0.0, 2.0, states, 0.0, 0, True)
    samples = sample_path(line, path, 0.01)
    turned = np.diff(samples.poses_map[:, 2])
    middle = 0.5 * (samples.curvature_1pm[1:] + samples.curvature_1pm[:-1])
    assert np.abs(turned / np.diff(samples.u_m) - middle).max() < 2e-3
    chords = np.hypot(*np.diff(samples.poses_map[:, :2], axis=0).T)
    assert chords.sum() == pytest.approx(samples.u_m[-1], rel=1e-5)


def test_the_way_is_inverted_to_a_tenth_of_a_millimetre() -> None:
    corridor = a_corridor(0.08)
    line = fit_line(corridor.s_m, corridor.points_map, 0.6)
    states = np.array([[0.3 * math.sin(0.7 * i), 0.1 * math.cos(i), 0.02] for i in range(20)])
    path = SolvedPath(0.0, 2.0, states, 0.0, 0, True)
    coarse, fine = sample_path(line, path, 0.25), sample_path(line, path, 0.005)
    assert np.abs(coarse.s_at(fine.u_m) - fine.s_m).max() < 1e-4
    poses, _ = poses_at(line, path, fine.s_m[::50])
    assert np.allclose(poses[:, :2], fine.poses_map[::50, :2], atol=1e-12)


def test_too_few_stations_make_no_frame() -> None:
    with pytest.raises(LineFolds):
        fit_line(np.arange(4.0), np.zeros((4, 2)), 0.6)
