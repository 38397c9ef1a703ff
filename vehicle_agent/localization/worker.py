"""The worker's part of localization by scans, whatever it compares them with: jobs and scans find each other.

Jobs come with every tick, scans ten times a second and a little late. A scan is answered from the place that
the vehicle had at the scan's stamp.
"""

from collections import deque
from typing import Protocol

import msgspec

from contract.geometry import compose, inverse
from contract.runlog.matched_scans import MatchedScan
from vehicle_agent.signals import LocalizationJob, ScanAnswer, ScanUnplaced
from vehicle_agent.signals.point_cloud import PointCloud
from vehicle_agent.signals.pose_history import pose_at

# A longer pause between two jobs is a restart of the tick, whose odometry then begins anew.
GAP_NS_MAX = 400_000_000
# Jobs that are kept, in time.
KEPT_NS = 1_000_000_000


class ScanMatcher(Protocol):
    """Compares scans with a map. Deterministic; it may remember what the last scans told."""

    def step(self, cloud: PointCloud, job: LocalizationJob) -> ScanAnswer:
        """Where the vehicle was at the scan's stamp.

        cloud  points in the base frame at its stamp; job: the vehicle at that stamp
        """
        ...

    def take_matched(self) -> MatchedScan | None:
        """A scan for the run log, if one is due; each is given once."""
        ...


class NoMap:
    """The matcher of a vehicle that waits for its map: every scan is unplaced, and GNSS goes on alone."""

    def step(self, cloud: PointCloud, job: LocalizationJob) -> ScanAnswer:
        del job
        return ScanUnplaced(cloud.stamp_ns, "no_map")

    def take_matched(self) -> MatchedScan | None:
        """None: there is no map that a scan could lie on."""
        return None


class LocalizationWorker:
    """One vehicle's worker: `take` each job, then `answer` each scan for which `is_ready`."""

    def __init__(self, matcher: ScanMatcher) -> None:
        self._matcher = matcher
        self._jobs: deque[LocalizationJob] = deque()

    def take(self, job: LocalizationJob) -> None:
        """Jobs in the order of their stamps; one that goes back or follows a pause begins anew."""
        jobs = self._jobs
        if jobs and not 0 < job.stamp_ns - jobs[-1].stamp_ns <= GAP_NS_MAX:
            jobs.clear()
        jobs.append(job)
        while job.stamp_ns - jobs[0].stamp_ns > KEPT_NS:
            jobs.popleft()

    def is_ready(self, stamp_ns: int) -> bool:
        """Whether the jobs reach a scan's stamp."""
        return bool(self._jobs) and self._jobs[-1].stamp_ns >= stamp_ns

    def answer(self, cloud: PointCloud) -> ScanAnswer | None:
        """None: no job says where the vehicle was then."""
        job = self._job_at(cloud.stamp_ns)
        return None if job is None else self._matcher.step(cloud, job)

    def take_matched(self) -> MatchedScan | None:
        """A scan for the run log, if one is due; each is given once."""
        return self._matcher.take_matched()

    def _job_at(self, stamp_ns: int) -> LocalizationJob | None:
        """What the newest job says of that moment."""
        jobs = self._jobs
        if not jobs or not jobs[0].stamp_ns <= stamp_ns <= jobs[-1].stamp_ns:
            return None
        newest = jobs[-1]
        odom_then = pose_at(tuple((job.stamp_ns, job.pose_odom) for job in jobs), stamp_ns)
        then_now = compose(inverse(odom_then), newest.pose_odom)
        pose_map = compose(newest.pose_map, inverse(then_now))
        return msgspec.structs.replace(newest, stamp_ns=stamp_ns, pose_map=pose_map, pose_odom=odom_then)
