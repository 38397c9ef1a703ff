"""Laser logs in CARMEN's text format: FLASER and ROBOTLASER1 lines, PARAM lines, odometry in either.

Format: one message a line, its name first, and at the end the stamp, the host and the logger's own stamp.
The stamp that names a scan, as in the relations of Kuemmerle et al. (2009), is the third-last field.
"""

import math
from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Array, IntArray, Pose2
from workshop.carmen.beams import Beams, no_return_m
from workshop.carmen.log_files import LogFileError, read_log_text

_KINDS = ("FLASER", "ROBOTLASER1")
_TRAILER = 3
# Laser pose and robot pose.
_POSES = 6
# ROBOTLASER1: speeds, safety distances, turn axis.
_ROBOT_LASER_EXTRAS = 5
_ROBOT_LASER_HEADER = 8
# A message that the network brought late is put back in its place. A greater step is a clock that was set.
_LATE_S_MAX = 1.0
_MOUNT_TOLERANCE_M = 0.005
_STANDING_M = 1e-3


class LaserLog(msgspec.Struct, frozen=True):
    """The scans of one log, in order of time.

    beams         the directions of all scans' readings, base x forward
    ranges_m      (n, m) distances; NaN where a reading is no return
    stamps_s      (n,) the log's own stamps
    odometry      (n, 3) x_m, y_m, yaw_rad of the base in the odometry frame
    T_base_laser  where the laser sits on the base
    notes         sentences about what was left out or repaired; empty for a clean log
    """

    beams: Beams
    ranges_m: Array
    stamps_s: Array
    odometry: Array
    T_base_laser: Pose2
    notes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.stamps_s)


class _Scan(msgspec.Struct, frozen=True):
    beams: Beams
    ranges_m: Array
    poses: Array
    stamp_s: float


def read_laser_log(path: Path) -> LaserLog:
    """The log of this file. Raises LogFileError where it holds no laser scan."""
    text, is_cut = read_log_text(path)
    lines = text.rstrip().split("\n")
    parameters: dict[str, str] = {}
    scans: dict[str, list[_Scan]] = {kind: [] for kind in _KINDS}
    odometry: list[Array] = []
    damaged = 0
    for number, line in enumerate(lines, start=1):
        name, _, rest = line.partition(" ")
        if name == "PARAM":
            key, _, value = rest.partition(" ")
            parameters[key] = value
        elif name in scans or name == "ODOM":
            try:
                if name == "ODOM":
                    odometry.append(_odometry(rest))
                else:
                    scans[name].append(_scan(name, rest))
            except ValueError:
                # The last line was being written when the log ended.
                is_cut = is_cut or number == len(lines)
                damaged += number < len(lines)
    kind = max(_KINDS, key=lambda name: len(scans[name]))
    if not scans[kind]:
        raise LogFileError(f"{path} is no CARMEN laser log: it has no whole FLASER or ROBOTLASER1 line.")
    notes = []
    if is_cut:
        notes.append("The log is cut off; what was whole before is used.")
    if damaged:
        notes.append(f"{damaged} damaged lines are left out.")
    return _log(scans[kind], odometry, parameters, notes)


def _scan(kind: str, rest: str) -> _Scan:
    """Raises ValueError where the line is not whole."""
    fields = rest.split()
    beams_at, extras = (0, 0) if kind == "FLASER" else (_ROBOT_LASER_HEADER - 1, _ROBOT_LASER_EXTRAS)
    if len(fields) <= beams_at:
        raise ValueError("no readings")
    count = int(fields[beams_at])
    first = beams_at + 1
    if count < 2 or len(fields) < first + count:
        raise ValueError("fewer readings than stated")
    after = first + count
    if kind == "ROBOTLASER1":
        after += 1 + int(fields[after])
        header = [float(value) for value in fields[1:5]]
        beams = Beams(header[0], header[2], count, header[3])
    else:
        beams = Beams.of_front_laser(count)
    if len(fields) != after + _POSES + extras + _TRAILER:
        raise ValueError("the line has another number of fields than its format")
    ranges_m = np.array(fields[first : first + count], dtype=np.float64)
    poses = np.array(fields[after : after + _POSES], dtype=np.float64)
    stamp_s = float(fields[-_TRAILER])
    if not (np.isfinite(poses).all() and math.isfinite(stamp_s)):
        raise ValueError("a pose or the stamp is not finite")
    return _Scan(beams, ranges_m, poses, stamp_s)


def _odometry(rest: str) -> Array:
    """(4,) stamp_s, x_m, y_m, yaw_rad. Raises ValueError where the line is not whole."""
    fields = rest.split()
    if len(fields) != 6 + _TRAILER:
        raise ValueError("the line has another number of fields than its format")
    row = np.array([fields[-_TRAILER], *fields[:3]], dtype=np.float64)
    if not np.isfinite(row).all():
        raise ValueError("a value is not finite")
    return row


def _log(scans: list[_Scan], odometry: list[Array], parameters: dict[str, str], notes: list[str]) -> LaserLog:
    beams = scans[0].beams
    alike = [scan for scan in scans if scan.beams == beams]
    if len(alike) < len(scans):
        notes.append(f"{len(scans) - len(alike)} scans with another number of beams are left out.")
    stamps_s = np.array([scan.stamp_s for scan in alike])
    order = _order(stamps_s, notes)
    stamps_s = stamps_s[order]
    poses = np.array([scan.poses for scan in alike])[order]
    ranges_m = np.array([scan.ranges_m for scan in alike])[order]
    limit_m = no_return_m(ranges_m, beams, parameters)
    with np.errstate(invalid="ignore"):
        ranges_m[~((ranges_m > 0.0) & (ranges_m < limit_m))] = np.nan
    bases = poses[:, 3:]
    if odometry and np.ptp(bases[:, :2], axis=0).max() < _STANDING_M:
        bases = _interpolated(np.array(odometry), stamps_s)
        mount = Pose2(0.0, 0.0, 0.0)
        notes.append("The scans carry no odometry; it is taken from the ODOM lines.")
    else:
        mount = _mount(poses, notes)
    return LaserLog(beams, ranges_m, stamps_s, bases, mount, tuple(notes))


def _order(stamps_s: Array, notes: list[str]) -> IntArray:
    """(n,) the scans in order of time, except that a clock which was set back leaves the file's order."""
    backward_s = np.maximum.accumulate(stamps_s) - stamps_s
    if (backward_s > _LATE_S_MAX).any():
        notes.append("The log's clock was set back; its scans keep the order of the file.")
        return np.arange(len(stamps_s))
    late = int((backward_s > 0.0).sum())
    if late:
        notes.append(f"{late} scans came late and are put back in order of time.")
    return np.argsort(stamps_s, kind="stable")


def _mount(poses: Array, notes: list[str]) -> Pose2:
    """The laser on the base, from poses (n, 6) of laser and base; none where the lines disagree, since then
    the laser's pose is a corrected one and no reading of odometry."""
    delta = poses[:, :2] - poses[:, 3:5]
    cos, sin = np.cos(poses[:, 5]), np.sin(poses[:, 5])
    forward_m, left_m = cos * delta[:, 0] + sin * delta[:, 1], cos * delta[:, 1] - sin * delta[:, 0]
    turns = np.exp(1j * (poses[:, 2] - poses[:, 5]))
    mean_turn = turns.mean()
    x_m, y_m = float(np.median(forward_m)), float(np.median(left_m))
    spread_m = float(np.percentile(np.hypot(forward_m - x_m, left_m - y_m), 95))
    if spread_m > _MOUNT_TOLERANCE_M or abs(mean_turn) < 1.0 - _MOUNT_TOLERANCE_M:
        notes.append("The laser's pose is not fixed to the base; the laser is taken to sit at its origin.")
        return Pose2(0.0, 0.0, 0.0)
    return Pose2(x_m, y_m, float(np.angle(mean_turn)))


def _interpolated(odometry: Array, stamps_s: Array) -> Array:
    """(n, 3) the odometry (k, 4) at these stamps; held at its ends."""
    odometry = odometry[np.argsort(odometry[:, 0], kind="stable")]
    yaw_rad = np.unwrap(odometry[:, 3])
    return np.stack(
        [np.interp(stamps_s, odometry[:, 0], column) for column in (odometry[:, 1], odometry[:, 2], yaw_rad)],
        axis=1,
    )
