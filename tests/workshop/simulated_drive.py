"""A laser's drive through a building whose walls and poses are known, and the log that it leaves."""

import math
from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Array, Pose2
from vehicle_agent.localization.laser.pose_arrays import between, composed
from workshop.carmen.beams import Beams
from workshop.carmen.laser_logs import LaserLog

# x0, y0, x1, y1: a corridor around a block, with rooms and pillars, so that no two places look alike.
WALLS = np.array(
    [
        (0, 0, 20, 0), (20, 0, 20, 14), (20, 14, 0, 14), (0, 14, 0, 0),
        (3, 3, 17, 3), (17, 3, 17, 11), (17, 11, 3, 11), (3, 11, 3, 3),
        (5, 0, 5, 0.7), (5, 0.7, 6.2, 0.7), (6.2, 0.7, 6.2, 0),
        (12, 0, 12, 0.5), (12, 0.5, 12.5, 0.5), (12.5, 0.5, 12.5, 0),
        (20, 4, 19.3, 4), (19.3, 4, 19.3, 6.5), (19.3, 6.5, 20, 6.5),
        (8, 14, 8, 13.2), (8, 13.2, 10, 13.2), (10, 13.2, 10, 14),
        (14, 11, 14, 11.5), (14, 11.5, 15.5, 11.5), (15.5, 11.5, 15.5, 11),
        (0, 8, 0.8, 8.8), (0.8, 8.8, 0, 9.6), (3, 5, 2.6, 5), (2.6, 5, 2.6, 5.8), (2.6, 5.8, 3, 5.8),
    ],
    dtype=np.float64,
)  # fmt: skip
CORNERS = np.array([(1.5, 1.5), (18.2, 1.5), (18.2, 12.5), (1.5, 12.5)])
NO_RETURN_M = 30.0


class SimulatedDrive(msgspec.Struct, frozen=True):
    """truth (n, 3) poses of the laser; log: what it recorded, with odometry that drifts."""

    truth: Array
    log: LaserLog


def drive(
    rounds: float = 1.25,
    step_m: float = 0.2,
    beams: Beams | None = None,
    noise_m: float = 0.01,
    seed: int = 1,
    slip: float = 0.06,
) -> SimulatedDrive:
    """Along the corridor, counter-clockwise, five scans a second.

    slip: share by which odometry overstates each way; it also turns by 1 degree a metre
    """
    rng = np.random.default_rng(seed)
    beams = beams or Beams.of_front_laser(181)
    truth = _way(rounds, step_m)
    ranges_m = np.array([_scan(pose, beams.angles_rad) for pose in truth])
    noisy = ranges_m + rng.normal(0.0, noise_m, ranges_m.shape)
    steps = between(truth[:-1], truth[1:])
    steps[:, :2] *= 1.0 + slip
    steps[:, 2] += math.radians(1.0) * step_m + rng.normal(0.0, math.radians(0.2), len(steps))
    odometry = [np.array([50.0, -3.0, 1.0])]
    for way in steps:
        odometry.append(composed(odometry[-1], way))
    stamps_s = 1000.0 + 0.2 * np.arange(len(truth))
    log = LaserLog(beams, noisy, stamps_s, np.array(odometry), Pose2(0.0, 0.0, 0.0), ())
    return SimulatedDrive(truth, log)


def flaser_line(log: LaserLog, number: int) -> str:
    """The scan as a CARMEN line; NaN becomes a reading beyond the laser's range."""
    readings = " ".join(f"{value:.2f}" for value in np.nan_to_num(log.ranges_m[number], nan=81.91))
    x_m, y_m, yaw_rad = log.odometry[number]
    pose = f"{x_m:.6f} {y_m:.6f} {yaw_rad:.6f}"
    stamp = f"{log.stamps_s[number]:.6f}"
    return f"FLASER {log.beams.count} {readings} {pose} {pose} {stamp} robot {0.2 * number:.6f}"


def write_carmen(log: LaserLog, path: Path) -> None:
    lines = ["# CARMEN Logfile", "PARAM robot_front_laser_max 80.0 1000.0 robot 0.0"]
    lines += [flaser_line(log, number) for number in range(len(log))]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def _way(rounds: float, step_m: float) -> Array:
    """(n, 3) poses along the rounded rectangle."""
    turn_m = 1.2
    legs = np.roll(CORNERS, -1, axis=0) - CORNERS
    dense: list[Array] = []
    for corner, leg in zip(CORNERS, legs, strict=True):
        length = float(np.hypot(*leg))
        heading = math.atan2(leg[1], leg[0])
        along = np.arange(turn_m, length - turn_m, 0.01)
        dense += [np.array([*(corner + leg / length * s), heading]) for s in along]
        centre = corner + leg / length * (length - turn_m) + turn_m * _left(heading)
        for turn in np.arange(0.0, math.pi / 2, 0.01 / turn_m):
            dense.append(np.array([*(centre - turn_m * _left(heading + turn)), heading + turn]))
    whole = np.array(dense)
    stride = round(step_m / 0.01)
    return whole[(np.arange(int(rounds * len(whole) / stride)) * stride) % len(whole)]


def _left(heading_rad: float) -> Array:
    return np.array([-math.sin(heading_rad), math.cos(heading_rad)])


def _scan(pose: Array, angles_rad: Array) -> Array:
    """(m,) true distances to the nearest wall; NaN beyond the laser's range."""
    rays = np.stack([np.cos(pose[2] + angles_rad), np.sin(pose[2] + angles_rad)], axis=1)
    starts, ways = WALLS[:, :2] - pose[:2], WALLS[:, 2:] - WALLS[:, :2]
    cross = rays[:, None, 0] * ways[None, :, 1] - rays[:, None, 1] * ways[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (starts[:, 0] * ways[:, 1] - starts[:, 1] * ways[:, 0]) / cross
        along = (starts[None, :, 0] * rays[:, None, 1] - starts[None, :, 1] * rays[:, None, 0]) / cross
    distance[~((along >= 0.0) & (along <= 1.0) & (distance > 0.0))] = np.inf
    nearest: Array = distance.min(axis=1)
    nearest[nearest >= NO_RETURN_M] = np.nan
    return nearest
