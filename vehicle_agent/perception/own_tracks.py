"""The perception worker of a vehicle that finds road users by itself."""

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.perception.dead_reckoning import ReckonedWay
from vehicle_agent.perception.pillars import sweeps
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.pillars.sweeps import Sweep
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.deskew import straightened
from vehicle_agent.perception.thinned_scans import ScanThinning, ThinnedScans
from vehicle_agent.signals import Percept, SignPercept, ThinnedScan
from vehicle_agent.signals.objects import EgoMotion, SeenObjects


class TracksWorker:
    """Obstacle cells and tracks from the points, scan after scan."""

    def __init__(
        self,
        perception: PointPerception,
        detector: PillarDetector | None = None,
        thinning: ScanThinning | None = None,
    ) -> None:
        """detector: a network that looks at the same scans; None: clusters alone.

        thinning  of scans that are shown
        """
        self._perception, self._detector = perception, detector
        self._sweeps: tuple[Sweep, ...] = ()
        self._way = ReckonedWay()
        self._state = perception.initial()
        self._shown = ThinnedScans(thinning)

    def take(self, motion: EgoMotion) -> None:
        self._way = self._way.with_motion(motion)

    def percepts(self, rows: np.ndarray, stamp_ns: int) -> tuple[Percept, ...]:
        points = self._straightened(rows)
        pose_odom = self._way.pose_odom(stamp_ns)
        found = self._found(points, rows[:, 3], stamp_ns, pose_odom)
        cells, tracks, self._state = self._perception.step(
            self._state, points, rows[:, 3], stamp_ns, pose_odom, found
        )
        return (cells, tracks)

    def _found(
        self, points: np.ndarray, intensities: np.ndarray, stamp_ns: int, pose_odom: Pose2
    ) -> SeenObjects | None:
        """What the network finds, with the velocities that the turn before shows."""
        if self._detector is None:
            return None
        newest = Sweep(stamp_ns, pose_odom, points, intensities)
        older, self._sweeps = sweeps.step(self._sweeps, newest)
        return self._detector.seen(points, intensities, stamp_ns, older)

    def signs(self, rows: np.ndarray, stamp_ns: int) -> tuple[SignPercept, ...]:
        del rows, stamp_ns
        return ()

    def thinned(self, rows: np.ndarray, stamp_ns: int) -> ThinnedScan | None:
        if not self._shown.takes(stamp_ns):
            return None
        thinning = self._shown.thinning
        return thinning.thinned(self._straightened(thinning.some_of(rows)), stamp_ns)

    def _straightened(self, rows: np.ndarray) -> np.ndarray:
        """(n, 3) the points as if all were measured at the stamp, once the motion is known."""
        newest, points = self._way.newest, np.ascontiguousarray(rows[:, :3])
        if newest is None:
            return points
        return straightened(points, rows[:, 4], newest.speed_mps, newest.yaw_rate_radps)
