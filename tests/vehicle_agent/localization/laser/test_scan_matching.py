"""Scan matching: a scan of known walls from a known place."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.workshop.simulated_drive import drive
from vehicle_agent.localization.laser.correlation import SearchWindow, correlate, rasterized
from vehicle_agent.localization.laser.point_index import index_points
from vehicle_agent.localization.laser.point_to_line import MatchParams, match_to_lines
from vehicle_agent.localization.laser.pose_arrays import between, composed, wrapped
from vehicle_agent.localization.laser.surfaces import SurfaceParams, scan_surface

DRIVE = drive(rounds=0.1, noise_m=0.003)
ANGLES = DRIVE.log.beams.angles_rad
SURFACES = [scan_surface(ranges_m, ANGLES, SurfaceParams()) for ranges_m in DRIVE.log.ranges_m]
REFERENCE = SURFACES[0]
INDEX = index_points(REFERENCE.points_laser, REFERENCE.normals_laser, 0.5)
RASTER = rasterized(REFERENCE.points_laser, 0.05, 0.05, 2.0)
NO_PRIOR = np.zeros((3, 3))
poses = st.tuples(*[st.floats(-20.0, 20.0)] * 2, st.floats(-4.0, 4.0)).map(np.array)


@given(poses, poses)
def test_between_undoes_composed(first: np.ndarray, way: np.ndarray) -> None:
    back = between(first, composed(first, way))
    assert back[:2] == pytest.approx(way[:2], abs=1e-9)
    assert wrapped(back[2:] - way[2:]) == pytest.approx([0.0], abs=1e-9)


def test_normals_are_square_to_the_wall_and_look_at_the_laser() -> None:
    angles = np.radians(np.arange(-30.0, 30.5, 0.5))
    surface = scan_surface(4.0 / np.cos(angles), angles, SurfaceParams())
    assert len(surface) > 30
    assert surface.normals_laser == pytest.approx(np.tile([-1.0, 0.0], (len(surface), 1)), abs=1e-6)
    gaps = np.linalg.norm(np.diff(surface.points_laser, axis=0), axis=1)
    assert gaps.min() >= 0.05


@pytest.mark.parametrize(
    "ranges_m",
    [
        np.full(181, np.nan),
        np.zeros(181),
        np.full(181, np.inf),
        np.full(181, -1.0),
        np.full(181, 81.91),
        np.zeros(0),
    ],
)
def test_a_scan_without_a_return_has_no_surface_and_matches_nothing(ranges_m: np.ndarray) -> None:
    surface = scan_surface(ranges_m, ANGLES[: len(ranges_m)], SurfaceParams())
    assert len(surface) == 0
    start = np.array([1.0, 2.0, 0.3])
    match = match_to_lines(surface, INDEX, start, NO_PRIOR, MatchParams())
    assert match.pose.tolist() == start.tolist()
    assert match.inlier_ratio == 0.0
    assert correlate(surface.points_laser, RASTER, start, SearchWindow(1.0, 0.5), np.zeros(2)).score == 0.0


@settings(max_examples=40, deadline=None)
@given(st.floats(-0.15, 0.15), st.floats(-0.15, 0.15), st.floats(-0.07, 0.07), st.integers(1, 4))
def test_a_match_finds_the_pose_from_anywhere_near(dx: float, dy: float, turn: float, number: int) -> None:
    true = between(DRIVE.truth[0], DRIVE.truth[number])
    start = true + np.array([dx, dy, turn])
    match = match_to_lines(SURFACES[number], INDEX, start, NO_PRIOR, MatchParams())
    assert match.pose[:2] == pytest.approx(true[:2], abs=0.02)
    assert match.pose[2] == pytest.approx(true[2], abs=math.radians(0.3))
    assert match.inlier_ratio > 0.5


def test_the_information_is_small_along_a_corridor() -> None:
    angles = np.radians(np.concatenate([np.arange(-90.0, -20.0), np.arange(20.0, 91.0)]))
    surface = scan_surface(1.5 / np.abs(np.sin(angles)), angles, SurfaceParams(range_m_max=10.0))
    index = index_points(surface.points_laser, surface.normals_laser, 0.5)
    prior = np.diag([1e4, 1e4, 1e4])
    match = match_to_lines(surface, index, np.array([0.05, 0.05, 0.0]), prior, MatchParams())
    assert match.information[0, 0] < 0.05 * match.information[1, 1]
    assert match.pose[0] == pytest.approx(0.05, abs=0.005)
    assert abs(match.pose[1]) < 0.03


@pytest.mark.parametrize("start", [(0.9, -0.7, 0.5), (-0.8, 0.9, -0.55), (0.0, 0.0, 0.3)])
def test_the_search_finds_the_best_pose_of_its_window(start: tuple[float, float, float]) -> None:
    true = between(DRIVE.truth[0], DRIVE.truth[3])
    found = correlate(
        SURFACES[3].points_laser, RASTER, true + np.array(start), SearchWindow(1.0, 0.6), np.zeros(2)
    )
    assert found.pose[:2] == pytest.approx(true[:2], abs=0.06)
    assert found.pose[2] == pytest.approx(true[2], abs=0.02)
    assert found.score > 0.6


def test_the_search_equals_trying_every_pose() -> None:
    points = SURFACES[2].points_laser[::16]
    start = between(DRIVE.truth[0], DRIVE.truth[2]) + np.array([0.2, -0.1, 0.015])
    found = correlate(points, RASTER, start, SearchWindow(0.45, 0.03), np.zeros(2))
    farthest_m = np.hypot(points[:, 0], points[:, 1]).max()
    turns = math.ceil(0.03 / (RASTER.cell_m / farthest_m))
    best = 0.0
    rows, columns = RASTER.nearness.shape
    for turn in range(-turns, turns + 1):
        turned = composed(
            np.array([start[0], start[1], start[2] + turn * 0.03 / turns]),
            np.column_stack([points, np.zeros(len(points))]),
        )
        column = np.floor((turned[:, 0] - RASTER.origin_x_m) / RASTER.cell_m).astype(int)
        row = np.floor((turned[:, 1] - RASTER.origin_y_m) / RASTER.cell_m).astype(int)
        for shift_y in range(-9, 10):
            for shift_x in range(-9, 10):
                r, c = row + shift_y, column + shift_x
                inside = (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
                best = max(best, float(RASTER.nearness[r[inside], c[inside]].sum()) / len(points))
    assert found.score == pytest.approx(best, abs=1e-6)
