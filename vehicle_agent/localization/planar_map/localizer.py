"""The worker's part of localization with a planar laser: scan by scan, where the vehicle is in the map.

NUS paper, section III-A: dead reckoning whose heading is corrected by scan matching carries the particles of
adaptive Monte-Carlo localization from one scan to the next, in a map that a laser made before.
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, compose, inverse, wrap_angle
from vehicle_agent.localization.laser import dead_reckoning
from vehicle_agent.localization.laser.dead_reckoning import DeadReckoningParams, DeadReckoningState
from vehicle_agent.localization.laser.surfaces import SurfaceParams
from vehicle_agent.localization.monte_carlo.likelihood_field import FieldParams
from vehicle_agent.localization.monte_carlo.localization import (
    MonteCarloEstimate,
    MonteCarloLocalization,
    MonteCarloParams,
    beam_ends,
    started_near,
)
from vehicle_agent.localization.planar_map.agreement import EvidenceParams
from vehicle_agent.localization.planar_map.field_window import FieldWindow, OccupancyTiles
from vehicle_agent.localization.planar_map.hypothesis import Hypothesis, RecentEvidence, is_apart
from vehicle_agent.localization.planar_map.place_finder import (
    Part,
    PlaceFinder,
    PlaceFinderParams,
    everywhere,
    nearby,
)
from vehicle_agent.signals import LocalizationJob, ScanAnswer, ScanPose, ScanUnplaced
from vehicle_agent.signals.laser_scan import LaserScan


class PlanarLocalizerParams(msgspec.Struct, frozen=True):
    """The filter, as it is used outdoors.

    around            tiles on each side of the vehicle's own, beyond the greatest range that is used
    beams_min         a scan with fewer returns says nothing of the place
    start_std_m       a prior that is surer gives the first particles; else its surroundings are searched
    start_floor_m, start_floor_rad  least spread of the first particles
    astray_m, astray_scans  particles that are so far from the vehicle's pose for so long, while the room does
                      not follow them, start again there
    evidence_keep     share of the evidence that stays from one scan to the next
    doubted, doubted_scans  particles that agree less for so long are doubted, and their surroundings searched
    disagreeing       for particles that agree less the whole map is searched, if nothing is found nearby
    search_rest_scans from one search to the next, if the last one has found nothing better
    better, better_agreement, better_scans  other particles for which so much more speaks, and which agree so
                      well, for so long take their place
    trial_scans       other particles that do not in this time are given up
    told_scans        answers after that which the room takes for another place's
    overruling_things, overruled_m  a place so far from the vehicle's pose is said only if so many things of a
                      scan lie on the map's walls there: few fit in many places
    alone_lead, alone_balance  as `lead` and `balance_min` of `finder`, where nothing but scans says where the
                      vehicle is
    """

    around: int = 1
    beams_min: int = 15
    start_std_m: float = 0.7
    start_floor_m: float = 0.15
    start_floor_rad: float = 0.02
    astray_m: float = 0.6
    astray_scans: int = 30
    evidence_keep: float = 0.7
    doubted: float = 0.7
    doubted_scans: int = 4
    disagreeing: float = 0.5
    search_rest_scans: int = 15
    better: float = 2.0
    better_agreement: float = 0.6
    better_scans: int = 8
    trial_scans: int = 25
    told_scans: int = 15
    overruling_things: float = 2.5
    overruled_m: float = 0.4
    alone_lead: float = 4.0
    alone_balance: float = 6.0
    evidence: EvidenceParams = EvidenceParams()
    finder: PlaceFinderParams = PlaceFinderParams()
    dead_reckoning: DeadReckoningParams = DeadReckoningParams(
        surface=SurfaceParams(range_m_max=30.0, spacing_m=0.1),
        keyframe_m=0.5,
        keyframe_rad=0.1,
        keyframes_max=8,
        odometry_m=0.004,
        odometry_rad=0.0015,
        odometry_ratio=0.02,
        slip_rad_per_m=0.001,
    )
    monte_carlo: MonteCarloParams = MonteCarloParams(
        field=FieldParams(hit_std_m=0.12, outlier_ratio=0.35, coarse_std_m=0.3),
        step_std_m=0.006,
        step_std_rad=0.002,
        way_ratio=0.08,
        turn_ratio=0.08,
        turn_radpm=0.01,
        slip_ratio=0.1,
        slip_m=0.06,
        slip_rad=0.02,
        # A lost vehicle stands, and must be found where it stands.
        standing_evidence=0.25,
        # Things hide the walls for longer than a fit may be low: `_Hypothesis` decides when to search.
        fit_lost=0.05,
        fit_lost_width=0.02,
        start_anew_max=0.0,
        lost_scans_max=1 << 40,
    )


class PlanarLocalizer:
    """One vehicle's worker. Equal scans, priors and seed give equal answers."""

    def __init__(
        self,
        tiles: OccupancyTiles,
        T_base_laser: Pose2,
        seed: int,
        params: PlanarLocalizerParams | None = None,
    ) -> None:
        self.params = params or PlanarLocalizerParams()
        self.tracked: Hypothesis | None = None
        self._other: Hypothesis | None = None
        self._finder: PlaceFinder | None = None
        self._searches: list[list[Part]] = []
        self._window = FieldWindow(tiles, self.params.monte_carlo.field, self.params.around)
        self._mount, self._mount_back = T_base_laser, inverse(T_base_laser)
        self._seed = seed
        self._reckoned: DeadReckoningState | None = None
        self._astray, self._doubted, self._better, self._fresh, self._rest = 0, 0, 0, 0, 0
        self._believed = RecentEvidence(self.params.evidence, self.params.evidence_keep)

    def step(self, scan: LaserScan, job: LocalizationJob) -> ScanAnswer:
        """Where the vehicle was at the scan's stamp; job: what was known of it besides, then."""
        params = self.params
        reckoned = self._dead_reckoned(scan, job)
        returns = int((np.isfinite(scan.ranges_m) & (scan.ranges_m > 0.0)).sum())
        if job.is_unknown:
            return self._found_alone(scan, reckoned, returns)
        laser = _array(compose(job.pose_map, self._mount))
        field = self._window.around(float(laser[0]), float(laser[1]))
        if field is None or returns < params.beams_min:
            # Particles would drift without anything that holds them.
            self._forget()
            return ScanUnplaced(scan.stamp_ns, "no_map" if field is None else "too_little")
        filter_ = MonteCarloLocalization(field, params.monte_carlo)
        if self.tracked is None and not self._start(filter_, scan, job, laser, reckoned):
            return ScanUnplaced(scan.stamp_ns, "searching")
        assert self.tracked is not None, "particles have been started"
        estimate = self.tracked.step(filter_, scan, reckoned)
        self._believed.add(filter_.beam_ends(scan.ranges_m, scan.angles_rad), laser, field)
        found = self._reconsidered(scan, estimate, reckoned)
        self._fresh = params.told_scans if found is not None else max(0, self._fresh - 1)
        pose = self._scan_pose(scan.stamp_ns, found or estimate, returns)
        away_m = math.hypot(pose.pose_map.x_m - job.pose_map.x_m, pose.pose_map.y_m - job.pose_map.y_m)
        if self._is_astray(away_m):
            self._forget()
        if away_m > params.overruled_m and not self._fresh and not self._says_a_place():
            # It contradicts the vehicle's pose, and is too little to say another.
            if self._believed.agreement >= params.disagreeing:
                return ScanUnplaced(scan.stamp_ns, "too_little")
            agreement = min(pose.agreement, self._believed.agreement)
            return msgspec.structs.replace(pose, agreement=agreement, through=1.0 - agreement)
        return pose

    def _says_a_place(self) -> bool:
        return self.tracked is not None and (
            self.tracked.evidence.things_on_walls >= self.params.overruling_things
        )

    def _forget(self) -> None:
        self.tracked = self._other = self._finder = None
        self._searches = []
        self._doubted = self._better = self._astray = self._rest = 0
        self._believed = RecentEvidence(self.params.evidence, self.params.evidence_keep)

    def _reconsidered(
        self, scan: LaserScan, estimate: MonteCarloEstimate, reckoned: Array
    ) -> MonteCarloEstimate | None:
        """The estimate of other particles for which much more has spoken for long enough to be believed."""
        params, tracked = self.params, self.tracked
        assert tracked is not None, "the other particles are compared with tracked ones"
        self._doubted = self._doubted + 1 if tracked.agreement < params.doubted else 0
        self._rest = max(0, self._rest - 1)
        if self._other is not None:
            return self._tried(scan, tracked, reckoned)
        if self._finder is None and self._doubted >= params.doubted_scans and not self._rest:
            self._search(scan, estimate.pose_map, tracked, reckoned)
        if self._finder is None:
            return None
        self._finder.step()
        if self._finder.is_over:
            pose = self._finder.found(reckoned)
            self._finder = None
            if pose is not None and is_apart(pose, estimate.pose_map, params.overruled_m, 0.1):
                self._other = self._around(pose, reckoned)
            elif not self._searches:
                self._rest = params.search_rest_scans
        return None

    def _search(self, scan: LaserScan, pose: Array, tracked: Hypothesis, reckoned: Array) -> None:
        """Begins the next search: the nearest first, and the others only while the scans disagree."""
        finder = self.params.finder
        is_disagreeing = tracked.agreement < self.params.disagreeing
        if not self._searches or not is_disagreeing:
            self._searches = nearby(pose, finder)
            far = everywhere(self._window, pose, finder)
            self._searches += [far] if far else []
        self._begin(scan, self._searches.pop(0), reckoned)
        if not is_disagreeing:
            self._searches = []

    def _begin(self, scan: LaserScan, parts: list[Part], reckoned: Array) -> None:
        params = self.params
        points = beam_ends(scan.ranges_m, scan.angles_rad, params.monte_carlo)
        self._finder = PlaceFinder(
            self._window, params.monte_carlo, params.evidence, params.finder, points, reckoned, parts
        )

    def _tried(self, scan: LaserScan, tracked: Hypothesis, reckoned: Array) -> MonteCarloEstimate | None:
        """The estimate of the other particles, if they have been better for long enough."""
        params, other = self.params, self._other
        assert other is not None, "there are other particles"
        estimate = self._stepped(other, scan, reckoned)
        if estimate is not None:
            more = other.evidence.balance - tracked.evidence.balance
            is_better = more > params.better and other.agreement >= params.better_agreement
            self._better = self._better + 1 if is_better else 0
            if self._better >= params.better_scans:
                self.tracked, self._other, self._searches = other, None, []
                self._doubted = self._better = 0
                return estimate
        if estimate is None or (other.scans >= params.trial_scans and not self._better):
            self._other, self._better = None, 0
            self._rest = 0 if self._searches else params.search_rest_scans
        return None

    def _stepped(self, some: Hypothesis, scan: LaserScan, reckoned: Array) -> MonteCarloEstimate | None:
        """None where the map has nothing."""
        x_m, y_m = some.state.poses[:, 0].mean(), some.state.poses[:, 1].mean()
        field = self._window.around(float(x_m), float(y_m))
        if field is None:
            return None
        return some.step(MonteCarloLocalization(field, self.params.monte_carlo), scan, reckoned)

    def _found_alone(self, scan: LaserScan, reckoned: Array, returns: int) -> ScanAnswer:
        """Of a vehicle of which nothing but its scans says where it is: the whole map is searched."""
        params = self.params
        searching = ScanUnplaced(scan.stamp_ns, "searching")
        if returns < params.beams_min:
            self._forget()
            return ScanUnplaced(scan.stamp_ns, "too_little")
        if self.tracked is not None:
            estimate = self._stepped(self.tracked, scan, reckoned)
            if estimate is None or self.tracked.agreement < params.better_agreement:
                self._forget()
                return searching
            return self._scan_pose(scan.stamp_ns, estimate, returns, alone=True)
        self._rest = max(0, self._rest - 1)
        if self._finder is None:
            parts = everywhere(self._window, None, params.finder)
            if not parts:
                return ScanUnplaced(scan.stamp_ns, "no_map")
            if self._rest:
                return searching
            self._begin(scan, parts, reckoned)
        assert self._finder is not None, "a search has begun"
        self._finder.step()
        if self._finder.is_over:
            pose = self._finder.found(reckoned, params.alone_lead, params.alone_balance)
            self._finder, self._rest = None, params.search_rest_scans
            self.tracked = None if pose is None else self._around(pose, reckoned)
        return searching

    def _around(self, pose: Array, reckoned: Array) -> Hypothesis:
        """Particles around a place (3,) of the laser."""
        params = self.params
        self._seed += 1
        state = started_near(
            params.monte_carlo, self._seed, pose, params.start_floor_m, params.start_floor_rad, reckoned
        )
        return Hypothesis(state, params.evidence, params.evidence_keep)

    def _dead_reckoned(self, scan: LaserScan, job: LocalizationJob) -> Array:
        """(3,) the laser since the first scan."""
        odometry = _array(compose(job.pose_odom, self._mount))
        output, self._reckoned = dead_reckoning.step(
            self._reckoned, scan.ranges_m, scan.angles_rad, odometry, self.params.dead_reckoning
        )
        return output.pose

    def _start(
        self,
        filter_: MonteCarloLocalization,
        scan: LaserScan,
        job: LocalizationJob,
        laser: Array,
        reckoned: Array,
    ) -> bool:
        """Particles around the prior if it is sure; else those of the place that a search around it finds."""
        params = self.params
        std_m = math.sqrt(max(job.covariance[0, 0], job.covariance[1, 1]))
        std_rad = max(params.start_floor_rad, math.sqrt(job.covariance[2, 2]))
        if std_m > params.start_std_m:
            if self._finder is None:
                self._begin(scan, nearby(laser, params.finder)[0], reckoned)
            assert self._finder is not None, "a search has begun"
            self._finder.step()
            if not self._finder.is_over:
                return False
            pose = self._finder.found(reckoned)
            self._finder = None
            if pose is not None:
                self.tracked = self._around(pose, reckoned)
                return True
        self._seed += 1
        state = filter_.near(self._seed, laser, max(params.start_floor_m, std_m), std_rad, reckoned)
        self.tracked = Hypothesis(state, params.evidence, params.evidence_keep)
        return True

    def _is_astray(self, away_m: float) -> bool:
        """Whether the room has long not believed the particles: what it knows besides says another place."""
        self._astray = self._astray + 1 if away_m > self.params.astray_m else 0
        if self._astray < self.params.astray_scans:
            return False
        self._astray = 0
        return True

    def _scan_pose(
        self, stamp_ns: int, estimate: MonteCarloEstimate, returns: int, *, alone: bool = False
    ) -> ScanPose:
        assert self.tracked is not None
        x_m, y_m, yaw_rad = (float(value) for value in estimate.pose_map)
        pose = compose(Pose2(x_m, y_m, yaw_rad), self._mount_back)
        # From the laser to the axle: the axle moves by the turn times the lever.
        lever = (pose.x_m - x_m, pose.y_m - y_m)
        moved = np.array([[1.0, 0.0, -lever[1]], [0.0, 1.0, lever[0]], [0.0, 0.0, 1.0]])
        covariance = moved @ estimate.covariance @ moved.T
        agreement = self.tracked.agreement
        if self._other is not None and self._better:
            # Scans that agree better elsewhere agree less here.
            agreement *= min(1.0, (1.0 - self._other.agreement) / max(1.0 - agreement, 1e-9))
        return ScanPose(
            stamp_ns,
            Pose2(pose.x_m, pose.y_m, wrap_angle(pose.yaw_rad)),
            0.5 * (covariance + covariance.T),
            agreement,
            returns,
            # Until the room has followed, it must not take the new place's agreement for the old one's.
            alone or self._fresh > 0,
            1.0 - agreement,
        )


def _array(pose: Pose2) -> Array:
    return np.array([pose.x_m, pose.y_m, pose.yaw_rad])
