"""Lidars whose true poses are known are found from a corner; where it leaves them open they are refused."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.calibration.corner import SimulatedRig, View, simulated_rig
from contract.transforms import angles_of, apart, inverse, moved, rotation_of, transform_of
from workshop.calibration.adjustment import Patch, adjust
from workshop.calibration.calibrate import calibrate
from workshop.calibration.errors import CalibrationError
from workshop.calibration.matching import from_ground, from_planes, kabsch
from workshop.calibration.planes import Plane, PlaneSearch, find_planes
from workshop.calibration.registration import surfaces_of
from workshop.calibration.residuals import residual
from workshop.calibration.rigs import load_rig

SAMPLE = (
    Path(os.environ.get("CAMPUSLOOP_SHARED", Path(__file__).resolve().parents[4] / "shared"))
    / "data" / "lidar" / "three_lidars"
)  # fmt: skip
ANGLES = st.floats(-3.1, 3.1)
TILTS = st.floats(-1.5, 1.5)
METRES = st.floats(-3.0, 3.0)
POSES = st.builds(
    lambda roll, pitch, yaw, x, y, z: transform_of(roll, pitch, yaw, np.array([x, y, z])),
    ANGLES, TILTS, ANGLES, METRES, METRES, METRES,
)  # fmt: skip


def rig(view: View, seed: int) -> SimulatedRig:
    return simulated_rig(view, np.random.default_rng(seed))


def wall(normal: list[float], offset_m: float) -> Plane:
    return Plane(np.array(normal) / np.linalg.norm(normal), offset_m, np.zeros((1, 3)), 20.0)


def seen_from(pose: np.ndarray, plane: Plane) -> Plane:
    """The plane as a sensor at this pose (T_reference_sensor) sees it."""
    return Plane(
        pose[:3, :3].T @ plane.normal, plane.offset_m + plane.normal @ pose[:3, 3], plane.points, 20.0
    )


GROUND, FRONT, SIDE = wall([0, 0, 1], 2.0), wall([-1, 0.1, 0], 5.0), wall([0.2, -1, 0], 7.0)


@given(ANGLES, TILTS, ANGLES)
def test_angles_come_back(roll: float, pitch: float, yaw: float) -> None:
    assert angles_of(transform_of(roll, pitch, yaw, np.zeros(3))) == pytest.approx(
        (roll, pitch, yaw), abs=1e-9
    )


@given(POSES, POSES)
def test_transforms_are_rigid_and_have_an_inverse(one: np.ndarray, other: np.ndarray) -> None:
    assert inverse(one) @ one == pytest.approx(np.eye(4), abs=1e-9)
    metres, angle_rad = apart(one, other)
    assert 0.0 <= angle_rad <= math.pi
    assert apart(other, one) == pytest.approx((metres, angle_rad))
    assert apart(one, one) == pytest.approx((0.0, 0.0), abs=1e-7)


@given(POSES)
def test_kabsch_finds_the_rotation_between_vectors(pose: np.ndarray) -> None:
    vectors = np.array([[1.0, 0.2, 0.0], [0.0, 1.0, 0.1], [0.3, 0.0, 1.0]])
    assert kabsch(vectors, vectors @ pose[:3, :3].T) == pytest.approx(pose[:3, :3], abs=1e-9)


@given(POSES)
def test_three_planes_give_the_pose_among_few_others(pose: np.ndarray) -> None:
    planes = [GROUND, FRONT, SIDE]
    starts = from_planes(planes, [seen_from(pose, plane) for plane in planes])
    assert min(sum(apart(start, pose)) for start in starts) < 1e-6
    assert len(starts) <= 6


def test_two_planes_give_none() -> None:
    parallel = wall([1, 0.1, 0], 3.0)
    assert from_planes([GROUND, FRONT], [GROUND, FRONT]) == []
    assert from_planes([GROUND, FRONT, parallel], [GROUND, FRONT, parallel]) == []


def test_the_ground_turns_a_guess_upright_and_lifts_it() -> None:
    pose = transform_of(0.0, 0.6, 1.2, np.array([0.3, -0.2, -0.4]))
    guess = transform_of(0.0, 0.0, 1.2, np.array([0.3, -0.2, 0.0]))
    (start,) = from_ground([GROUND], [seen_from(pose, GROUND)], guess)
    assert start[2, :3] == pytest.approx(pose[2, :3], abs=1e-9)
    assert start[2, 3] == pytest.approx(-0.4)
    assert start[:2, 3] == pytest.approx([0.3, -0.2])


def test_planes_of_a_corner_are_its_ground_and_walls() -> None:
    rng = np.random.default_rng(3)
    across = rng.uniform(0.0, 6.0, (3, 4_000, 2))
    points = [
        np.column_stack((across[0], np.full(4_000, -2.0))),
        np.column_stack((np.full(4_000, 5.0), across[1])) - [0.0, 0.0, 2.0],
        np.column_stack((across[2][:, 0], np.full(4_000, 4.0), across[2][:, 1])) - [0.0, 0.0, 2.0],
    ]
    clutter = rng.uniform(-3.0, 6.0, (800, 3))
    scan = np.vstack([*points, clutter]) + rng.normal(0.0, 0.01, (12_800, 3))
    planes = find_planes(scan, PlaneSearch())[:3]
    found = sorted((tuple(np.round(plane.normal, 2) + 0.0), round(plane.offset_m, 1)) for plane in planes)
    assert found == [((-1.0, 0.0, 0.0), 5.0), ((0.0, -1.0, 0.0), 4.0), ((0.0, 0.0, 1.0), 2.0)]
    assert all(len(plane.points) > 3_500 for plane in planes)


def test_adjustment_of_points_without_noise_is_exact() -> None:
    rng = np.random.default_rng(4)
    truth = np.array([np.eye(4), transform_of(0.1, -0.2, 2.0, np.array([0.5, 1.0, -0.3]))])
    patches = []
    for normal in ([0, 0, 1], [1, 0, 0], [0, 1, 0.1], [1, 1, 0], [0.3, -1, 0.4], [0, 0, 1]):
        unit = np.array(normal) / np.linalg.norm(normal)
        on = rng.uniform(-4.0, 4.0, (200, 3))
        on -= np.outer(on @ unit - rng.uniform(2.0, 6.0), unit)
        patches.append(Patch((on[:100], moved(inverse(truth[1]), on[100:]))))
    start = truth.copy()
    start[1, :3, :3] = rotation_of(np.array([0.02, -0.01, 0.03])) @ start[1, :3, :3]
    start[1, :3, 3] += [0.1, -0.05, 0.08]
    found = adjust(patches, start)
    assert sum(apart(found.transforms[1], truth[1])) < 1e-9
    assert np.array_equal(found.transforms[0], np.eye(4))


def test_a_corner_gives_poses_within_a_centimetre_and_a_tenth_of_a_degree() -> None:
    vehicle = rig("corner", 1004)
    names = [str(number) for number in range(len(vehicle.clouds))]
    found = calibrate(names, vehicle.clouds, [None] * len(names))
    for ours, true in zip(found.transforms[1:], vehicle.truth[1:], strict=True):
        metres, angle_rad = apart(ours, true)
        assert metres < 0.01
        assert math.degrees(angle_rad) < 0.1


def test_where_a_direction_is_open_no_pose_is_given() -> None:
    vehicle = rig("street", 7)
    truths = [None, *(true for true in vehicle.truth[1:])]
    names = [str(number) for number in range(len(vehicle.clouds))]
    # Not even with good guesses: nothing in the scans confirms them.
    with pytest.raises(CalibrationError) as refused:
        calibrate(names, vehicle.clouds, truths)
    assert refused.value.code == "degenerate"


def test_one_lidar_or_an_empty_scan_is_refused() -> None:
    cloud = np.random.default_rng(1).uniform(-5.0, 5.0, (1_000, 3))
    for clouds, code in (([cloud], "too_few_lidars"), ([cloud, cloud[:10]], "too_few_points")):
        with pytest.raises(CalibrationError) as refused:
            calibrate(["a", "b"][: len(clouds)], clouds, [None] * len(clouds))
        assert refused.value.code == code


def test_scans_of_two_different_places_do_not_match() -> None:
    one, other = rig("corner", 1002), rig("corner", 1004)
    guess = transform_of(0.0, 0.0, 0.5, np.array([0.5, 0.0, 0.0]))
    far = moved(transform_of(0.4, 0.3, 0.0, np.array([30.0, 10.0, 4.0])), other.clouds[0])
    with pytest.raises(CalibrationError) as refused:
        calibrate(["a", "b"], [one.clouds[0], far[np.linalg.norm(far, axis=1) > 20.0]], [None, guess])
    assert refused.value.code in ("no_match", "ambiguous", "too_few_planes", "degenerate")


def test_real_lidars_fit_better_than_as_given_also_by_what_was_not_optimised() -> None:
    if not SAMPLE.exists():
        pytest.skip("no recorded rig here; set CAMPUSLOOP_SHARED to the folder that has data/lidar")
    vehicle = load_rig(SAMPLE)
    found = calibrate(vehicle.names, vehicle.clouds, vehicle.guesses)
    surfaces = surfaces_of(vehicle.clouds[0])
    for number in (1, 2):
        guess = vehicle.guesses[number]
        assert guess is not None
        given_m, ours_m = (
            residual(vehicle.clouds[0], surfaces, vehicle.clouds[number], pose)
            for pose in (guess, found.transforms[number])
        )
        assert ours_m.plane_m < 0.6 * given_m.plane_m
        assert ours_m.thickness_m < 0.6 * given_m.thickness_m
        assert not found.kept[number]
    # The mounts mirror each other: 45 degrees down, half a metre to both sides.
    left, right = (found.transforms[vehicle.names.index(name)] for name in ("left", "right"))
    assert left[:3, 3] * [1, -1, 1] == pytest.approx(right[:3, 3], abs=0.04)
