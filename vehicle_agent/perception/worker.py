"""What the perception worker makes of scans: cells alone, or cells and the tracks of road users.

The worker is a process beside the tick. Its percepts go to tick and gate alike.
"""

from typing import Protocol

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.perception.dead_reckoning import ReckonedWay
from vehicle_agent.perception.height_map import HeightMap, percept_from_scan
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.signals import Percept
from vehicle_agent.signals.objects import EgoMotion


class PerceptionWorker(Protocol):
    """Deterministic: the same motions and scans give the same percepts."""

    def take(self, motion: EgoMotion) -> None:
        """One tick's motion; each is older than the scans that follow it, or about to be."""
        ...

    def percepts(
        self, points_base: np.ndarray, intensities: np.ndarray, stamp_ns: int
    ) -> tuple[Percept, ...]:
        """Of one scan: points (n, 3) float32 in the base frame at its end, intensities (n,)."""
        ...


class CellsWorker:
    """Obstacle cells by the height map; road users come from another computer, or the stack tracks none."""

    def __init__(self, height_map: HeightMap) -> None:
        self._height_map = height_map

    def take(self, motion: EgoMotion) -> None:
        """Cells need no motion."""

    def percepts(
        self, points_base: np.ndarray, intensities: np.ndarray, stamp_ns: int
    ) -> tuple[Percept, ...]:
        del intensities
        return (percept_from_scan(points_base, stamp_ns, self._height_map),)


class TracksWorker:
    """Obstacle cells and tracks from the points alone, scan after scan."""

    def __init__(self, perception: PointPerception) -> None:
        self._perception = perception
        self._way = ReckonedWay()
        self._state = perception.initial()

    def take(self, motion: EgoMotion) -> None:
        self._way = self._way.with_motion(motion)

    def percepts(
        self, points_base: np.ndarray, intensities: np.ndarray, stamp_ns: int
    ) -> tuple[Percept, ...]:
        pose_odom: Pose2 = self._way.pose_odom(stamp_ns)
        cells, tracks, self._state = self._perception.step(
            self._state, points_base, intensities, stamp_ns, pose_odom
        )
        return (cells, tracks)
