"""The turns of the lidars that a vehicle remembers, so that the detector sees what moved between two."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Pose2

Array32 = NDArray[np.float32]

# The older turn ended so long before the newer one; the detector learned with this.
OLDER_NS = 200_000_000
# A turn that is off by more is not used.
_OFF_NS_MAX = 60_000_000
_SWEEPS_MAX = 8


class Sweep(NamedTuple):
    """One turn of all lidars: points (n, 3), base frame at stamp_ns; intensities (n,); pose by odometry."""

    stamp_ns: int
    pose_odom: Pose2
    points_base: Array32
    intensities: Array32


class OlderTurn(NamedTuple):
    """points_base (n, 3) in the base frame of now, intensities (n,); how much older it is."""

    points_base: Array32
    intensities: Array32
    older_s: float


def step(memory: tuple[Sweep, ...], newest: Sweep) -> tuple[OlderTurn | None, tuple[Sweep, ...]]:
    """(the turn about 0.2 s before, moved to the newest's frame, memory). None where none is near that time.

    A newest one that is not later than the last begins the memory again.
    """
    if memory and newest.stamp_ns <= memory[-1].stamp_ns:
        memory = ()
    wanted_ns = newest.stamp_ns - OLDER_NS
    nearest = min(memory, key=lambda sweep: abs(sweep.stamp_ns - wanted_ns), default=None)
    kept = tuple(
        sweep for sweep in (*memory, newest) if sweep.stamp_ns > newest.stamp_ns - OLDER_NS - _OFF_NS_MAX
    )
    if nearest is None or abs(nearest.stamp_ns - wanted_ns) > _OFF_NS_MAX:
        return None, kept[-_SWEEPS_MAX:]
    older_s = (newest.stamp_ns - nearest.stamp_ns) * 1e-9
    older = OlderTurn(_moved(nearest, newest.pose_odom), nearest.intensities, older_s)
    return older, kept[-_SWEEPS_MAX:]


def _moved(sweep: Sweep, to: Pose2) -> Array32:
    """(n, 3) the sweep's points in the base frame at another pose; heights stay."""
    at = sweep.pose_odom
    cos, sin = math.cos(to.yaw_rad), math.sin(to.yaw_rad)
    dx, dy = at.x_m - to.x_m, at.y_m - to.y_m
    x, y = cos * dx + sin * dy, -sin * dx + cos * dy
    c, s = math.cos(at.yaw_rad - to.yaw_rad), math.sin(at.yaw_rad - to.yaw_rad)
    points = sweep.points_base
    moved = np.empty_like(points)
    moved[:, 0] = c * points[:, 0] - s * points[:, 1] + x
    moved[:, 1] = s * points[:, 0] + c * points[:, 1] + y
    moved[:, 2] = points[:, 2]
    return moved
