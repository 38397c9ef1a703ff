"""An inertial unit whose true pose is known is found from a drive; a drive that cannot tell is refused."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.calibration.motion import MotionDrive, Way
from contract.geometry import Array
from contract.transforms import rotation_of
from vehicle_agent.signals.point_cloud import point_cloud
from workshop.calibration.errors import CalibrationError
from workshop.motion_calibration.calibrate import MotionParams, calibrate_motion
from workshop.motion_calibration.clock import clock_offset_s
from workshop.motion_calibration.drive import (
    InertialDrive,
    LidarMotion,
    inertial_drive,
    lidar_motion,
    motion_of,
)
from workshop.motion_calibration.integration import rotation_vectors

# Begin and spacing of the lidar's scans.
STAMPS_NS = 1_000_000_000 + 100_000_000 * np.arange(2_000)


def recorded(drive: MotionDrive) -> LidarMotion:
    """The lidar's true way with the errors of an odometry: 0.02 degrees and 8 mm in each scan."""
    rng = np.random.default_rng(5)
    poses = drive.lidar_poses().copy()
    for pose in poses:
        pose[:3, :3] = pose[:3, :3] @ rotation_of(rng.normal(0.0, 3e-4, 3))
        pose[:3, 3] += rng.normal(0.0, 0.008, 3)
    return motion_of(STAMPS_NS[: len(poses)], poses)


@pytest.fixture(scope="module")
def bends() -> MotionDrive:
    return MotionDrive(3, "bends", 45.0)


@pytest.fixture(scope="module")
def motion(bends: MotionDrive) -> LidarMotion:
    return recorded(bends)


@pytest.fixture(scope="module")
def unit(bends: MotionDrive) -> InertialDrive:
    return bends.inertial()


def test_bends_to_both_sides_give_the_rotation_and_the_clock(
    bends: MotionDrive, motion: LidarMotion, unit: InertialDrive
) -> None:
    found = calibrate_motion(motion, unit, bends.T_lidar_unit[:3, 3])
    off = rotation_vectors((found.T_lidar_unit[:3, :3] @ bends.T_lidar_unit[:3, :3].T)[None])[0]
    assert math.degrees(float(np.linalg.norm(off))) < 0.5
    assert (np.abs(off) < 4.0 * found.rotation_std_rad).all()
    assert found.offset_s == pytest.approx(bends.offset_s, abs=0.003)
    assert abs(found.offset_s - bends.offset_s) < 4.0 * found.offset_std_s


def test_a_level_drive_keeps_the_given_height_of_the_lever_arm_and_finds_the_rest(
    bends: MotionDrive, motion: LidarMotion, unit: InertialDrive
) -> None:
    given = bends.T_lidar_unit[:3, 3] + np.array([0.3, -0.3, 0.2])
    found = calibrate_motion(motion, unit, given)
    (direction,) = found.kept
    assert abs(float(direction @ found.up)) > 0.95
    lever = found.T_lidar_unit[:3, 3]
    assert float(direction @ lever) == pytest.approx(float(direction @ given), abs=0.005)
    off = lever - bends.T_lidar_unit[:3, 3]
    # What the given height is off leaks through the kept direction, which is not quite upright.
    level = off - direction * float(direction @ off)
    assert float(np.linalg.norm(level)) < 0.15


def test_the_given_lever_arm_does_not_turn_the_unit(motion: LidarMotion, unit: InertialDrive) -> None:
    one = calibrate_motion(motion, unit)
    other = calibrate_motion(motion, unit, np.array([1.0, 1.0, -2.0]))
    off = rotation_vectors((one.T_lidar_unit[:3, :3] @ other.T_lidar_unit[:3, :3].T)[None])[0]
    assert (np.abs(off) < one.rotation_std_rad).all()


@pytest.mark.parametrize(("way", "code"), [("stands", "no_motion"), ("straight", "no_turns")])
def test_a_drive_that_cannot_tell_is_refused_with_what_to_drive(way: Way, code: str) -> None:
    drive = MotionDrive(8, way, 30.0)
    with pytest.raises(CalibrationError, match="bends to each side") as refused:
        calibrate_motion(recorded(drive), drive.inertial())
    assert refused.value.code == code


def test_what_is_not_known_well_enough_is_refused(motion: LidarMotion, unit: InertialDrive) -> None:
    with pytest.raises(CalibrationError) as refused:
        calibrate_motion(motion, unit, params=MotionParams(rotation_std_rad_max=1e-5))
    assert refused.value.code == "degenerate"


@pytest.mark.parametrize("shift_s", [-0.7, 0.0, 1.4e9])
def test_clocks_of_any_epoch_are_laid_over_each_other(
    bends: MotionDrive, motion: LidarMotion, unit: InertialDrive, shift_s: float
) -> None:
    shifted = InertialDrive(
        unit.stamps_s, unit.rates_radps, unit.forces_mps2, unit.start_ns - round(shift_s * 1e9), unit.gaps
    )
    found_s = clock_offset_s(motion, shifted) - shift_s
    assert found_s == pytest.approx(bends.offset_s, abs=0.05)


def test_samples_of_another_drive_have_no_clock_in_common(motion: LidarMotion) -> None:
    with pytest.raises(CalibrationError) as refused:
        clock_offset_s(motion, MotionDrive(4, "bends", 45.0).inertial())
    assert refused.value.code in ("no_common_time", "ambiguous")


def test_gaps_in_both_recordings_are_left_out(
    bends: MotionDrive, motion: LidarMotion, unit: InertialDrive
) -> None:
    scans = np.ones(len(motion.stamps_s), dtype=bool)
    scans[200:212] = False
    samples = np.ones(len(unit.stamps_s), dtype=bool)
    samples[len(samples) // 3 : len(samples) // 3 + 60] = False
    cut_motion = motion_of(STAMPS_NS[: len(scans)][scans], motion.poses[scans])
    stamps_ns = unit.start_ns + np.rint(1e9 * unit.stamps_s).astype(np.int64)
    cut_unit = inertial_drive(stamps_ns[samples], unit.rates_radps[samples], unit.forces_mps2[samples])
    found = calibrate_motion(cut_motion, cut_unit, bends.T_lidar_unit[:3, 3])
    off = rotation_vectors((found.T_lidar_unit[:3, :3] @ bends.T_lidar_unit[:3, :3].T)[None])[0]
    assert math.degrees(float(np.linalg.norm(off))) < 0.5


def _table(change: Callable[[Array, Array, Array], None]) -> tuple[np.ndarray, Array, Array]:
    stamps = 10_000_000 * np.arange(300)
    rates, forces = np.zeros((300, 3)), np.tile([0.0, 0.0, 9.81], (300, 1))
    change(stamps, rates, forces)
    return stamps, rates, forces


def test_samples_that_are_no_samples_are_refused() -> None:
    def nan(_: Array, rates: Array, __: Array) -> None:
        rates[5, 1] = np.nan

    def in_g(_: Array, __: Array, forces: Array) -> None:
        forces /= 9.81

    def back(stamps: Array, _: Array, __: Array) -> None:
        stamps[:] = stamps[::-1].copy()

    for change, code in ((nan, "bad_samples"), (in_g, "bad_samples"), (back, "too_few_samples")):
        with pytest.raises(CalibrationError) as refused:
            inertial_drive(*_table(change))
        assert refused.value.code == code


def test_too_few_scans_are_no_drive() -> None:
    scans = (point_cloud(100_000_000 * number, np.ones((10, 3))) for number in range(20))
    with pytest.raises(CalibrationError) as refused:
        lidar_motion(scans)
    assert refused.value.code == "too_few_scans"
