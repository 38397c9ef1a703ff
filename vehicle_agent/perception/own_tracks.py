"""The perception worker of a vehicle that finds road users by itself."""

from typing import Protocol

import msgspec
import numpy as np

from contract.geometry import Pose2
from vehicle_agent.perception.dead_reckoning import ReckonedWay
from vehicle_agent.perception.pillars import sweeps
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.pillars.sweeps import Sweep
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.deskew import straightened
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.thinned_scans import ScanThinning, ThinnedScans
from vehicle_agent.signals import Percept, SignPercept, ThinnedScan
from vehicle_agent.signals.objects import EgoMotion, SeenObjects


class RoadUserFinder(Protocol):
    """Finds road users beside the clusters of the points; what both find is one object."""

    def found(
        self, points: np.ndarray, intensities: np.ndarray, stamp_ns: int, pose_odom: Pose2
    ) -> SeenObjects | None:
        """What is there at stamp_ns; None: it cannot tell. points (n, 3) and intensities (n,) of the scan."""
        ...


class NetworkFinder:
    """The network that looks at the same scan, with the velocities that the turn before shows."""

    def __init__(self, detector: PillarDetector) -> None:
        self._detector = detector
        self._sweeps: tuple[Sweep, ...] = ()

    def found(
        self, points: np.ndarray, intensities: np.ndarray, stamp_ns: int, pose_odom: Pose2
    ) -> SeenObjects | None:
        newest = Sweep(stamp_ns, pose_odom, points, intensities)
        older, self._sweeps = sweeps.step(self._sweeps, newest)
        return self._detector.seen(points, intensities, stamp_ns, older)


class BelowBeams(msgspec.Struct, frozen=True):
    """Who stands before the bumper below the lidars' beams: what a worker that is started again must know.

    people_base   x, y and diameter of each, base frame
    waved_on_ns   the newest wave of an operator that they have outlasted
    """

    people_base: tuple[tuple[float, float, float], ...] = ()
    waved_on_ns: int = 0


class TracksWorker:
    """Obstacle cells and tracks from the points, scan after scan."""

    def __init__(
        self,
        perception: PointPerception,
        finder: RoadUserFinder | None = None,
        thinning: ScanThinning | None = None,
        sign_finder: SignFinder | None = None,
    ) -> None:
        """finder: looks at the same surroundings; None: clusters alone.

        thinning  of scans that are shown
        sign_finder  None for a stack that reads no signs
        """
        self._perception, self._finder, self._sign_finder = perception, finder, sign_finder
        self._way = ReckonedWay()
        self._state = perception.initial()
        self._waved_on_ns = 0
        self._pose_odom = Pose2(0.0, 0.0, 0.0)
        self._remembered: np.ndarray | None = None
        self._shown = ThinnedScans(thinning)

    def take(self, motion: EgoMotion) -> None:
        self._way = self._way.with_motion(motion)
        # A tick that was started again has heard no operator yet, and begins with 0.
        if motion.waved_on_ns > self._waved_on_ns:
            self._waved_on_ns = motion.waved_on_ns
            self._state = self._perception.without_below(self._state)
            self._remembered = None

    def below_beams(self) -> BelowBeams:
        """As of the newest scan."""
        people = self._perception.people_below(self._state, self._pose_odom)
        return BelowBeams(tuple((float(x), float(y), float(d)) for x, y, d in people), self._waved_on_ns)

    def remember(self, below: BelowBeams) -> None:
        """Who was there when an earlier worker ended; before the first scan.

        The vehicle is taken not to have moved since: without percepts it brakes.
        """
        self._remembered = np.array(below.people_base).reshape(-1, 3)
        self._waved_on_ns = below.waved_on_ns

    def percepts(self, rows: np.ndarray, stamp_ns: int) -> tuple[Percept, ...]:
        points = self._straightened(rows)
        pose_odom = self._pose_odom = self._way.pose_odom(stamp_ns)
        if self._remembered is not None:
            self._state = self._perception.with_below(self._state, self._remembered, pose_odom)
            self._remembered = None
        finder = self._finder
        found = None if finder is None else finder.found(points, rows[:, 3], stamp_ns, pose_odom)
        cells, tracks, self._state = self._perception.step(
            self._state, points, rows[:, 3], stamp_ns, pose_odom, found
        )
        return (cells, tracks)

    def signs(self, rows: np.ndarray, stamp_ns: int) -> tuple[SignPercept, ...]:
        if self._sign_finder is None:
            return ()
        return (self._sign_finder.percept(self._straightened(rows), rows[:, 3], stamp_ns),)

    def thinned(self, rows: np.ndarray, stamp_ns: int) -> ThinnedScan | None:
        if not self._shown.takes(stamp_ns):
            return None
        thinning = self._shown.thinning
        return thinning.thinned(self._straightened(thinning.some_of(rows)), stamp_ns)

    def _straightened(self, rows: np.ndarray) -> np.ndarray:
        """(n, 3) the points of a scan as they are seen from the vehicle at the scan's stamp."""
        points = np.ascontiguousarray(rows[:, :3])
        newest = self._way.newest
        if newest is None:
            return points
        return straightened(points, rows[:, 4], newest.speed_mps, newest.yaw_rate_radps)
