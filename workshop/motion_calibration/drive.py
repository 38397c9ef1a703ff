"""What a recorded drive gives to the calibration: the lidar's poses and the unit's samples."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.odometry.lidar_odometry import LidarOdometry
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.calibration.errors import CalibrationError

# A scan of which so few points found a partner does not know where it is.
_PARTNERS_MIN = 0.4
# Between scans, and between samples: what is longer is a gap.
_SCAN_GAP_S, _SAMPLE_GAP_S = 0.35, 0.1
_SCANS_MIN, _SAMPLES_MIN = 50, 200


@dataclass(frozen=True, slots=True, eq=False)
class LidarMotion:
    """stamps_s (n,) rising, in the lidar's clock, from the first scan; poses (n, 4, 4) T_map_lidar.

    start_ns   the first scan's stamp
    pieces     (n,) poses of different pieces are not compared: between them is a gap, or a scan that does not
               know where it is
    """

    stamps_s: Array
    poses: Array
    start_ns: int
    pieces: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class InertialDrive:
    """stamps_s (n,) rising, in the unit's clock, from the first sample; rates_radps and forces_mps2 (n, 3).

    start_ns    the first sample's stamp
    forces_mps2 the specific force: (0, 0, 9.81) at rest on level ground
    gaps        (n,) gaps between samples before each
    """

    stamps_s: Array
    rates_radps: Array
    forces_mps2: Array
    start_ns: int
    gaps: np.ndarray


def lidar_motion(scans: Iterable[PointCloud], step: Callable[[], None] = lambda: None) -> LidarMotion:
    """The lidar's way by its odometry; CalibrationError if there are too few scans.

    The poses are at the middles of the scans: a scan that was straightened with a turn rate that is a little
    wrong is right there, while at its begin it lags by some milliseconds in every bend. Scans whose stamps do
    not rise are left out. step: is told of each scan, for a bar of progress.
    """
    odometry = LidarOdometry()
    stamps: list[int] = []
    poses: list[Array] = []
    known: list[bool] = []
    for scan in scans:
        step()
        centred = _centred(scan)
        if stamps and centred.stamp_ns <= stamps[-1]:
            continue
        found = odometry.step(centred)
        known.append(not poses or found.partners >= _PARTNERS_MIN * max(1, found.points))
        stamps.append(centred.stamp_ns)
        poses.append(found.pose)
    if len(stamps) < _SCANS_MIN:
        raise CalibrationError(
            "too_few_scans", f"{len(stamps)} scans with rising stamps; a drive has {_SCANS_MIN} or more"
        )
    return motion_of(np.array(stamps), np.array(poses), np.array(known))


def _centred(scan: PointCloud) -> PointCloud:
    """The scan with its stamp in the middle of its points' times."""
    if len(scan) == 0:
        return scan
    middle_ns = (int(scan.offsets_ns.min()) + int(scan.offsets_ns.max())) // 2
    return PointCloud(
        scan.stamp_ns + middle_ns,
        scan.points_sensor,
        scan.intensities,
        scan.rings,
        scan.offsets_ns - middle_ns,
    )


def motion_of(stamps_ns: np.ndarray, poses: Array, known: np.ndarray | None = None) -> LidarMotion:
    """Of rising stamps (n,) and poses (n, 4, 4); known (n,): the scan knows where it is."""
    stamps_s = 1e-9 * (stamps_ns - stamps_ns[0])
    known = np.ones(len(stamps_s), dtype=bool) if known is None else known
    breaks = np.diff(stamps_s, prepend=stamps_s[0]) > _SCAN_GAP_S
    # A scan that is lost is a piece of its own: the one after it begins another.
    breaks |= ~known | ~np.concatenate(([True], known[:-1]))
    return LidarMotion(stamps_s, poses, int(stamps_ns[0]), np.cumsum(breaks))


def inertial_drive(stamps_ns: np.ndarray, rates_radps: Array, forces_mps2: Array) -> InertialDrive:
    """Of samples (n,), (n, 3), (n, 3) in the order of recording; CalibrationError says what is wrong.

    Samples whose stamps do not rise are left out, as a driver that sends one twice makes them.
    """
    newest = np.maximum.accumulate(stamps_ns) if len(stamps_ns) else stamps_ns
    rising = np.concatenate(([True], stamps_ns[1:] > newest[:-1])) if len(stamps_ns) else newest.astype(bool)
    stamps_ns, rates, forces = stamps_ns[rising], rates_radps[rising], forces_mps2[rising]
    if len(stamps_ns) < _SAMPLES_MIN:
        raise CalibrationError(
            "too_few_samples", f"{len(stamps_ns)} samples with rising stamps; a drive has {_SAMPLES_MIN}"
        )
    if not (np.isfinite(rates).all() and np.isfinite(forces).all()):
        raise CalibrationError("bad_samples", "a sample has a value that is not finite")
    usual_mps2 = float(np.median(np.linalg.norm(forces, axis=1)))
    if not 8.0 < usual_mps2 < 11.5:
        raise CalibrationError(
            "bad_samples",
            f"the usual specific force is {usual_mps2:.2f} m/s2 instead of 9.81; give m/s2, with gravity",
        )
    stamps_s = 1e-9 * (stamps_ns - stamps_ns[0])
    gaps = np.cumsum(np.diff(stamps_s, prepend=0.0) > _SAMPLE_GAP_S)
    return InertialDrive(stamps_s, rates, forces, int(stamps_ns[0]), gaps)
