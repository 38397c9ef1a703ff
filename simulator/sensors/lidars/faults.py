"""Faults of a lidar, for tests of what must notice them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, Protocol

import numpy as np

from simulator.sensors.lidars.planar_scanner import PlanarScan, PlanarScanner
from simulator.sensors.lidars.scanner import MovingBodies, Trajectory
from simulator.sensors.lidars.spinning_lidar import LidarScan
from vehicle_agent.signals.point_cloud import PointCloud

LidarFault = Literal["dead", "frozen", "saturated", "not_finite"]

_SATURATED = 255.0
_LOST_EVERY = 7


class ScanSource(Protocol):
    """A spinning lidar, or what stands in for one."""

    def scan(self, trajectory: Trajectory, begin_ns: int, moving: Sequence[MovingBodies] = ()) -> LidarScan:
        """The turn that begins at begin_ns."""
        ...


class FaultyLidar:
    """A lidar whose `fault` may be set at any time; None while it works.

    dead        no scan at all
    frozen      the last scan again and again, with new stamps
    saturated   each intensity is the greatest
    not_finite  every seventh point has no coordinates (NaN)
    """

    def __init__(self, lidar: ScanSource) -> None:
        self.fault: LidarFault | None = None
        self._lidar = lidar
        self._last: LidarScan | None = None

    def scan(
        self, trajectory: Trajectory, begin_ns: int, moving: Sequence[MovingBodies] = ()
    ) -> LidarScan | None:
        """The turn that begins at begin_ns, as the fault leaves it; None if the sensor is dead."""
        if self.fault == "dead":
            return None
        if self.fault == "frozen" and self._last is not None:
            return _with_cloud(self._last, begin_ns)
        scan = self._lidar.scan(trajectory, begin_ns, moving)
        self._last = scan
        if self.fault == "saturated":
            full = np.full(len(scan.cloud), _SATURATED, dtype=np.float32)
            return _with_cloud(scan, begin_ns, intensities=full)
        if self.fault == "not_finite":
            return _holed(scan)
        return scan


class FaultyPlanarScanner:
    """A planar scanner whose `fault` may be set at any time; None while it works. Faults are a lidar's."""

    def __init__(self, scanner: PlanarScanner) -> None:
        self.fault: LidarFault | None = None
        self._scanner = scanner
        self._last: PlanarScan | None = None

    def scan(
        self, trajectory: Trajectory, begin_ns: int, moving: Sequence[MovingBodies] = ()
    ) -> PlanarScan | None:
        """The turn that begins at begin_ns, as the fault leaves it; None if the sensor is dead."""
        if self.fault == "dead":
            return None
        if self.fault == "frozen" and self._last is not None:
            return replace(self._last, stamp_ns=begin_ns)
        scan = self._scanner.scan(trajectory, begin_ns, moving)
        self._last = scan
        if self.fault == "saturated":
            return replace(scan, intensities=np.full(len(scan.intensities), _SATURATED, dtype=np.float32))
        if self.fault == "not_finite":
            ranges = scan.ranges_m.copy()
            ranges[::_LOST_EVERY] = np.nan
            return replace(scan, ranges_m=ranges)
        return scan


def _with_cloud(scan: LidarScan, stamp_ns: int, intensities: np.ndarray | None = None) -> LidarScan:
    cloud = scan.cloud
    values = cloud.intensities if intensities is None else intensities
    again = PointCloud(stamp_ns, cloud.points_sensor, values, cloud.rings, cloud.offsets_ns)
    return LidarScan(again, scan.points_base, scan.ghosts)


def _holed(scan: LidarScan) -> LidarScan:
    cloud = scan.cloud
    points, based = cloud.points_sensor.copy(), scan.points_base.copy()
    points[::_LOST_EVERY] = np.nan
    based[::_LOST_EVERY] = np.nan
    holed = PointCloud(cloud.stamp_ns, points, cloud.intensities, cloud.rings, cloud.offsets_ns)
    return LidarScan(holed, based, scan.ghosts)
