"""The pose of an inertial unit on a lidar, and the offset of their clocks, from one drive."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from contract.geometry import Array
from workshop.calibration.errors import CalibrationError
from workshop.motion_calibration.adjustment import Adjustment, LeverPrior, UnitPrior, adjust
from workshop.motion_calibration.clock import clock_offset_s
from workshop.motion_calibration.comparison import LEVER, TURN
from workshop.motion_calibration.drive import InertialDrive, LidarMotion
from workshop.motion_calibration.first_guess import first_guess
from workshop.motion_calibration.integration import rotation_vectors
from workshop.motion_calibration.windows import Windows, windows_of


@dataclass(frozen=True, slots=True)
class MotionParams:
    """Parameters of the calibration by motion.

    turn_s, half_s   between the scans of a pair, and between the neighbours of a triple
    margin_s         around the samples' ends, more than the first clock offset errs
    block_s          windows that begin within so long err together
    way_m_min        of a drive
    turned_rad_min   sum of all bends; slower turns than `bend_radps` are no bends
    rotation_std_rad_max, offset_std_s_max  standard deviations above which the drive is refused
    lever_std_m_max  above which a direction of the lever arm keeps its given value
    """

    turn_s: float = 1.0
    half_s: float = 1.5
    margin_s: float = 0.1
    block_s: float = 6.0
    way_m_min: float = 10.0
    turned_rad_min: float = 3.0
    bend_radps: float = 0.08
    rotation_std_rad_max: float = 0.009
    offset_std_s_max: float = 0.01
    lever_std_m_max: float = 0.05
    prior: UnitPrior = field(default_factory=UnitPrior)


@dataclass(frozen=True, slots=True, eq=False)
class MotionCalibration:
    """What was found.

    T_lidar_unit     (4, 4)
    rotation_std_rad, lever_std_m  (3,) about and along the lidar's axes, without what kept directions are off
    offset_s, offset_std_s  has to be added to the unit's stamps to be the lidar's time
    kept             (k, 3) directions of the lever arm, lidar frame, that the drive does not tell: they have
                     the given value
    up               (3,) the vertical in the lidar's frame, mean of the drive
    way_m, turned_rad  the drive's length, and the sum of its bends
    """

    T_lidar_unit: Array
    rotation_std_rad: Array
    lever_std_m: Array
    offset_s: float
    offset_std_s: float
    kept: Array
    up: Array
    way_m: float
    turned_rad: float
    windows: Windows
    adjustment: Adjustment


def calibrate_motion(
    lidar: LidarMotion, unit: InertialDrive, given_lever_m: Array | None = None,
    params: MotionParams | None = None,
) -> MotionCalibration:  # fmt: skip
    """Finds the unit's pose; deterministic. CalibrationError says why a drive is refused.

    given_lever_m  (3,) of the unit in the lidar's frame, as measured by tape; 0 without it
    """
    params = params or MotionParams()
    way_m, turned_rad = check_drive(lidar, params)
    offset_s = clock_offset_s(lidar, unit)
    windows = windows_of(lidar, unit, offset_s, params.turn_s, params.half_s, params.margin_s)
    if min(len(windows.pairs), len(windows.triples)) < 100:
        raise CalibrationError(
            "too_few_scans", f"{len(windows.triples)} stretches of {2 * params.half_s:.0f} s without gaps"
        )
    start = first_guess(lidar, unit, offset_s, windows)
    given = np.zeros(3) if given_lever_m is None else given_lever_m
    try:
        free = adjust(lidar, unit, start, windows, params.block_s, params.prior, LeverPrior(given))
        kept = _untold(free, params.lever_std_m_max)
        found = free
        if len(kept):
            held = replace(free.unknowns, lever_m=free.unknowns.lever_m + _off(kept, given, free))
            lever = LeverPrior(given, kept)
            found = adjust(lidar, unit, held, windows, params.block_s, params.prior, lever)
    except np.linalg.LinAlgError as error:
        raise CalibrationError("degenerate", f"the drive determines no pose: {_WHAT_TO_DRIVE}") from error
    _check_found(found, params)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = found.unknowns.rotation, found.unknowns.lever_m
    stds = np.sqrt(np.diag(found.covariance))
    return MotionCalibration(
        pose, stds[TURN], stds[LEVER], found.unknowns.offset_s, float(stds[6]), kept,
        _up(lidar, found), way_m, turned_rad, windows, found,
    )  # fmt: skip


_WHAT_TO_DRIVE = (
    "drive two or three bends to each side, such as an eight, at 2 to 5 m/s, and brake and start in between"
)


def check_drive(lidar: LidarMotion, params: MotionParams) -> tuple[float, float]:
    """(way in m, sum of bends in rad); CalibrationError for a drive that stands or goes straight."""
    steps = np.linalg.norm(np.diff(lidar.poses[::10, :3, 3], axis=0), axis=1)
    # A lidar that stands is a few millimetres off in each scan.
    way_m = float(steps[steps > 0.05].sum())
    if way_m < params.way_m_min:
        raise CalibrationError("no_motion", f"the vehicle drives {way_m:.1f} m only: {_WHAT_TO_DRIVE}")
    first, last = lidar.poses[:-10:10, :3, :3], lidar.poses[10::10, :3, :3]
    count = min(len(first), len(last))
    turns = rotation_vectors(first[:count].transpose(0, 2, 1) @ last[:count])
    spans_s = (lidar.stamps_s[10::10] - lidar.stamps_s[:-10:10])[:count]
    sizes = np.linalg.norm(turns, axis=1)
    turned_rad = float(sizes[sizes > params.bend_radps * spans_s].sum())
    if turned_rad < params.turned_rad_min:
        raise CalibrationError(
            "no_turns",
            f"all bends together are {math.degrees(turned_rad):.0f} degrees;"
            f" {math.degrees(params.turned_rad_min):.0f} are needed: {_WHAT_TO_DRIVE}",
        )
    return way_m, turned_rad


def _untold(found: Adjustment, std_m_max: float) -> Array:
    """(k, 3) directions in which the lever arm is less surely known than std_m_max."""
    values, directions = np.linalg.eigh(found.covariance[LEVER, LEVER])
    untold: Array = directions.T[np.sqrt(np.maximum(values, 0.0)) > std_m_max]
    return untold


def _off(kept: Array, given: Array, found: Adjustment) -> Array:
    """(3,) from what was found to the given value, along the kept directions."""
    away: Array = kept.T @ (kept @ (given - found.unknowns.lever_m))
    return away


def _check_found(found: Adjustment, params: MotionParams) -> None:
    stds = np.sqrt(np.diag(found.covariance))
    worst = float(stds[TURN].max())
    if not worst <= params.rotation_std_rad_max:
        raise CalibrationError(
            "degenerate", f"the rotation is known to {math.degrees(worst):.2f} degrees only: {_WHAT_TO_DRIVE}"
        )
    if not stds[6] <= params.offset_std_s_max:
        raise CalibrationError(
            "degenerate", f"the clocks' offset is known to {1e3 * stds[6]:.0f} ms only: {_WHAT_TO_DRIVE}"
        )


def _up(lidar: LidarMotion, found: Adjustment) -> Array:
    up = -(found.unknowns.gravity_mps2 @ lidar.poses[:, :3, :3]).mean(axis=0)
    unit: Array = up / np.linalg.norm(up)
    return unit
