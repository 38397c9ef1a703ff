"""Whether a lidar still is where it was calibrated: the road under the vehicle tells. Pure.

The vehicle stands on the plane z = 0 of its own frame, and so does the road around it, but for crests, dips
and what the springs give. While it drives these cancel over a minute; a lidar that was knocked sees the road
elsewhere. A vehicle that stands before a ramp sees the same: this is a word to people, no reason to stop.
"""

import math
from collections import deque

import msgspec
import numpy as np

from contract.geometry import Array


class MountLimits(msgspec.Struct, frozen=True):
    """near_m, far_m     horizontal distances of points that may be road
    beside_m             to both sides of the vehicle: its own lane, since roads have a crown, and kerbs
    up_m, slope          how far from z = 0 the road may seem to be, with a share of the distance
    inlier_m             of the plane; points_min, share_min: of those that lie on it
    noise_m              of one point, as if no two erred together
    height_std_m, slope_std  a turn that shows the plane less surely does not count
    every_ns             one turn in so long is looked at
    turns                whose median counts; fewer than turns_min say nothing
    together_m, together_rad, together_share  so many of them must say nearly the same
    tilt_rad, height_m   beyond these a lidar is called moved
    """

    near_m: float = 2.5
    far_m: float = 20.0
    beside_m: float = 3.0
    up_m: float = 0.3
    slope: float = 0.2
    inlier_m: float = 0.08
    points_min: int = 60
    share_min: float = 0.3
    noise_m: float = 0.05
    height_std_m: float = 0.04
    slope_std: float = 0.012
    every_ns: int = 1_000_000_000
    turns: int = 60
    turns_min: int = 30
    together_m: float = 0.08
    together_rad: float = 0.025
    together_share: float = 0.7
    tilt_rad: float = 0.03
    height_m: float = 0.1


class MountDrift(msgspec.Struct, frozen=True):
    """By how much a lidar seems to have moved, medians in the vehicle's frame.

    height_m  upwards; roll_rad to the right side down, pitch_rad nose down (REP-103)
    """

    height_m: float
    roll_rad: float
    pitch_rad: float


# Triples that are tried, and points that they are tried on.
_TRIPLES, _POINTS = 60, 400


class MountWatch:
    """One lidar. Give it the turns that are due; it says whether the lidar has moved."""

    def __init__(self, limits: MountLimits | None = None) -> None:
        self._limits = limits or MountLimits()
        self._planes: deque[Array] = deque(maxlen=self._limits.turns)
        self._looked_ns: int | None = None

    def is_due(self, stamp_ns: int) -> bool:
        """Whether this turn is to be looked at."""
        return self._looked_ns is None or not 0 <= stamp_ns - self._looked_ns < self._limits.every_ns

    def add(self, stamp_ns: int, points_base: np.ndarray) -> None:
        """One turn; points_base (n, 3), by the calibrated mount."""
        self._looked_ns = stamp_ns
        plane = ground_plane(points_base, self._limits, seed=len(self._planes))
        if plane is not None:
            self._planes.append(plane)

    @property
    def drift(self) -> MountDrift | None:
        """None while it is where it should be, or too few turns have shown the road."""
        limits = self._limits
        if len(self._planes) < limits.turns_min:
            return None
        planes = np.array(self._planes)
        middle = np.median(planes, axis=0)
        apart = np.abs(planes - middle)
        together = (apart[:, 0] <= limits.together_m) & (apart[:, 1:] <= limits.together_rad).all(axis=1)
        if together.mean() < limits.together_share:
            # Verges, kerbs and cars: what is seen is no road, or not always.
            return None
        up_m, slope_x, slope_y = middle
        # A road that seems to rise ahead is seen by a lidar whose nose went down.
        pitch_rad, roll_rad = math.atan(slope_x), -math.atan(slope_y)
        tilt_rad, height_m = math.hypot(pitch_rad, roll_rad), -float(up_m)
        if tilt_rad <= limits.tilt_rad and abs(height_m) <= limits.height_m:
            return None
        return MountDrift(height_m, roll_rad, pitch_rad)


def ground_plane(points_base: np.ndarray, limits: MountLimits, seed: int = 0) -> Array | None:
    """(3,) height at the axle and slopes ahead and to the left of the road; None where it is not seen."""
    points = points_base.astype(np.float64)
    away_m = np.hypot(points[:, 0], points[:, 1])
    near = (away_m >= limits.near_m) & (away_m <= limits.far_m)
    near &= np.abs(points[:, 1]) <= limits.beside_m
    near &= np.abs(points[:, 2]) <= limits.up_m + limits.slope * away_m
    points = points[near]
    if len(points) < limits.points_min:
        return None
    rng = np.random.default_rng(seed)
    some = points[rng.permutation(len(points))[:_POINTS]]
    triples = some[rng.integers(0, len(some), (_TRIPLES, 3))]
    planes: list[Array] = [found for found in map(_through, triples) if found is not None]
    if not planes:
        return None
    counts = [int((np.abs(some[:, 2] - _ones(some) @ one) <= limits.inlier_m).sum()) for one in planes]
    plane = planes[int(np.argmax(counts))]
    for _ in range(3):
        on = np.abs(points[:, 2] - _ones(points) @ plane) <= limits.inlier_m
        if on.sum() < max(limits.points_min, limits.share_min * len(points)):
            return None
        plane = _fitted(points[on])
    return plane if _is_sure(points[on], limits) else None


def _fitted(points: Array) -> Array:
    plane: np.ndarray = np.linalg.lstsq(_ones(points), points[:, 2], rcond=None)[0]
    return plane


def _is_sure(points: Array, limits: MountLimits) -> bool:
    """Whether points (n, 3) that lie where these do say more of the plane than is asked of them."""
    matrix = _ones(points)
    variances = np.diag(np.linalg.inv(matrix.T @ matrix)) * limits.noise_m**2
    return bool(variances[0] <= limits.height_std_m**2 and variances[1:].max() <= limits.slope_std**2)


def _ones(points: Array) -> Array:
    return np.column_stack((np.ones(len(points)), points[:, :2]))


def _through(triple: Array) -> Array | None:
    """z = a + b x + c y through three points; None where they are nearly in line, or the plane is steep."""
    matrix = _ones(triple)
    if abs(np.linalg.det(matrix)) < 0.5:
        return None
    plane: Array = np.linalg.solve(matrix, triple[:, 2]).astype(np.float64)
    return plane if abs(plane[1]) < 0.4 and abs(plane[2]) < 0.4 else None
