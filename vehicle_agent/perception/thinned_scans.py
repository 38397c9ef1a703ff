"""Scans for people who look at a run: a few points above the road, once a second."""

import msgspec
import numpy as np

from vehicle_agent.signals import ThinnedScan

# Centimetres of 16 bits reach so far.
_CM_MAX = 32_767


class ScanThinning(msgspec.Struct, frozen=True):
    """Parameters.

    every_ns             between two scans that are shown
    above_m, below_m     heights above the plane of the wheels: not the road, not what hangs over it
    reach_m              from the rear axle
    own_m                rear, front and half width of what is taken for the own body's returns, base frame
    looked_at_max        points: of a larger scan every second, third ... is taken
    voxel_m, points_max  one point in each cube of this side; the side is doubled until the points are so few
    """

    every_ns: int = 1_000_000_000
    above_m: float = 0.2
    below_m: float = 4.0
    reach_m: float = 40.0
    own_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    looked_at_max: int = 24_000
    voxel_m: float = 0.25
    points_max: int = 1_200

    def some_of(self, rows: np.ndarray) -> np.ndarray:
        """Every second, third ... row of a large scan."""
        return rows[:: max(1, -(-len(rows) // self.looked_at_max))]

    def thinned(self, points_base: np.ndarray, stamp_ns: int) -> ThinnedScan:
        """points_base (n, 3) in metres, base frame; points that are not finite are left out."""
        points = self.some_of(points_base)
        heights, ranges_m = points[:, 2], np.hypot(points[:, 0], points[:, 1])
        is_shown = (heights > self.above_m) & (heights < self.below_m) & (ranges_m < self.reach_m)
        rear_m, front_m, side_m = self.own_m
        is_own = (points[:, 0] > rear_m) & (points[:, 0] < front_m) & (np.abs(points[:, 1]) < side_m)
        points, side_m = points[is_shown & ~is_own], self.voxel_m
        kept = _one_in_each(points, side_m)
        while len(kept) > self.points_max:
            side_m *= 2.0
            kept = _one_in_each(kept, side_m)
        points_cm = np.clip(np.rint(100.0 * kept), -_CM_MAX, _CM_MAX).astype("<i2")
        return ThinnedScan(stamp_ns, points_cm.tobytes())


class ThinnedScans:
    """Knows which scans are due."""

    def __init__(self, thinning: ScanThinning | None = None) -> None:
        self.thinning = thinning or ScanThinning()
        self._last_ns: int | None = None

    def takes(self, stamp_ns: int) -> bool:
        """Whether this scan is the next to be shown; a clock that went back begins again."""
        last_ns = self._last_ns
        if last_ns is not None and 0 <= stamp_ns - last_ns < self.thinning.every_ns:
            return False
        self._last_ns = stamp_ns
        return True


def _one_in_each(points: np.ndarray, side_m: float) -> np.ndarray:
    """The first point of each cube, in the order of the scan."""
    cubes = np.floor(points / side_m).astype(np.int64)
    keys = (cubes[:, 0] * 4096 + cubes[:, 1]) * 4096 + cubes[:, 2]
    _, firsts = np.unique(keys, return_index=True)
    kept: np.ndarray = points[np.sort(firsts)]
    return kept
