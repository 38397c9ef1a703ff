"""Scan-matched dead reckoning on drives whose truth is known."""

import numpy as np
import pytest

from tests.workshop.simulated_drive import SimulatedDrive, drive
from vehicle_agent.localization.laser import dead_reckoning
from vehicle_agent.localization.laser.dead_reckoning import DeadReckoningParams, DeadReckoningState
from vehicle_agent.localization.laser.pose_arrays import between

DRIVE = drive(rounds=0.4)
PARAMS = DeadReckoningParams()


def reckoned(
    driven: SimulatedDrive, ranges_m: np.ndarray | None = None, odometry: np.ndarray | None = None
) -> np.ndarray:
    """(n, 3) poses."""
    state: DeadReckoningState | None = None
    poses = []
    ranges_m = driven.log.ranges_m if ranges_m is None else ranges_m
    odometry = driven.log.odometry if odometry is None else odometry
    for scan, pose in zip(ranges_m, odometry, strict=True):
        output, state = dead_reckoning.step(state, scan, driven.log.beams.angles_rad, pose, PARAMS)
        poses.append(output.pose)
    return np.array(poses)


def end_error_m(driven: SimulatedDrive, poses: np.ndarray) -> float:
    error = between(between(driven.truth[0], driven.truth[-1]), between(poses[0], poses[-1]))
    return float(np.hypot(error[0], error[1]))


def test_it_stays_near_the_truth_where_odometry_does_not() -> None:
    assert end_error_m(DRIVE, DRIVE.log.odometry) > 2.0
    assert end_error_m(DRIVE, reckoned(DRIVE)) < 0.1


def test_without_a_return_it_goes_with_odometry() -> None:
    poses = reckoned(DRIVE, np.full_like(DRIVE.log.ranges_m, np.nan))
    expected = between(DRIVE.log.odometry[0], DRIVE.log.odometry[-1])
    assert poses[-1] == pytest.approx(expected, abs=1e-6)


def test_saturated_scans_in_between_do_not_lose_it() -> None:
    ranges_m = DRIVE.log.ranges_m.copy()
    ranges_m[20:24] = np.nan
    assert end_error_m(DRIVE, reckoned(DRIVE, ranges_m)) < 0.15


def test_odometry_that_jumps_does_not_move_it() -> None:
    odometry = DRIVE.log.odometry.copy()
    odometry[30:] += np.array([700.0, -40.0, 0.0])
    assert end_error_m(DRIVE, reckoned(DRIVE, odometry=odometry)) < 0.2


def test_a_standing_laser_has_a_standing_pose() -> None:
    state: DeadReckoningState | None = None
    for _ in range(5):
        output, state = dead_reckoning.step(
            state, DRIVE.log.ranges_m[0], DRIVE.log.beams.angles_rad, DRIVE.log.odometry[0], PARAMS
        )
    assert output.pose.tolist() == [0.0, 0.0, 0.0]
    assert output.match is None


def test_slow_motion_is_not_standing() -> None:
    odometry = np.zeros(3)
    state: DeadReckoningState | None = None
    ranges_m = np.full(DRIVE.log.beams.count, np.nan)
    for number in range(100):
        odometry = np.array([0.0005 * number, 0.0, 0.0])
        output, state = dead_reckoning.step(state, ranges_m, DRIVE.log.beams.angles_rad, odometry, PARAMS)
    assert output.pose[0] == pytest.approx(0.0495, abs=0.002)


def test_a_bare_corridor_does_not_hold_the_laser_back() -> None:
    """Its walls say nothing of the way along it, so that the wheels must."""
    rng = np.random.default_rng(3)
    angles = np.radians(np.arange(-90.0, 91.0))
    with np.errstate(divide="ignore"):
        walls_m = 1.25 / np.abs(np.sin(angles))
    state: DeadReckoningState | None = None
    for number in range(80):
        ranges_m = walls_m + rng.normal(0.0, 0.01, len(angles))
        ranges_m[ranges_m > 8.0] = np.nan
        odometry = np.array([0.25 * number, 0.0, 0.0])
        output, state = dead_reckoning.step(state, ranges_m, angles, odometry, PARAMS)
    assert output.pose[0] == pytest.approx(0.25 * 79, abs=0.5)
    assert abs(output.pose[1]) < 0.6


def test_equal_inputs_give_equal_poses() -> None:
    assert (reckoned(DRIVE) == reckoned(DRIVE)).all()
