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
from vehicle_agent.localization.monte_carlo.likelihood_field import FieldParams, LikelihoodField
from vehicle_agent.localization.monte_carlo.localization import (
    MonteCarloEstimate,
    MonteCarloLocalization,
    MonteCarloParams,
    MonteCarloState,
)
from vehicle_agent.localization.planar_map.agreement import (
    BESIDE_MAP,
    ON_WALL,
    SHORT,
    THROUGH_WALL,
    counted_beams,
)
from vehicle_agent.localization.planar_map.field_window import FieldWindow, OccupancyTiles, free_near
from vehicle_agent.signals import LocalizationJob, ScanAnswer, ScanPose, ScanUnplaced
from vehicle_agent.signals.laser_scan import LaserScan


class PlanarLocalizerParams(msgspec.Struct, frozen=True):
    """The filter, as it is used outdoors.

    around            tiles on each side of the vehicle's own, beyond the greatest range that is used
    beams_min         a scan with fewer returns says nothing of the place
    start_std_m       a prior that is surer gives the first particles; else its surroundings are searched
    start_floor_m, start_floor_rad  least spread of the first particles
    search_m          farthest place from the prior that a search takes for the vehicle's
    search_again_m    way after which that disc is drawn again
    astray_m, astray_scans  particles that are so far from the vehicle's pose for so long, while the room does
                      not follow them, start again there
    clear_m           a wall within so much of a beam's end, or of the laser, is not passed through
    short_weight      of a beam that ends short of all walls: people and trucks hide what is behind them
    agreement_keep    share of the agreement that stays from one scan to the next
    doubted, doubted_scans  particles that agree less for so long are doubted, and their surroundings searched
    search_rest_scans from one search to the next
    better, better_scans  other particles that agree so much more for so long take their place
    overruling_beams, overruled_m  a place so far from the vehicle's pose is said only if so many beams of a
                      scan lie on the map's walls there: few fit in many places
    """

    around: int = 1
    beams_min: int = 15
    start_std_m: float = 0.7
    start_floor_m: float = 0.15
    start_floor_rad: float = 0.02
    search_m: float = 12.0
    search_again_m: float = 3.0
    astray_m: float = 0.6
    astray_scans: int = 30
    clear_m: float = 0.5
    short_weight: float = 0.1
    agreement_keep: float = 0.7
    doubted: float = 0.35
    doubted_scans: int = 8
    search_rest_scans: int = 50
    better: float = 0.35
    better_scans: int = 15
    overruling_beams: float = 15.0
    overruled_m: float = 0.4
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


class _Hypothesis:
    """Particles that may be right, and how their scans agree with the map of late."""

    def __init__(self, state: MonteCarloState, params: PlanarLocalizerParams) -> None:
        self.state = state
        self._params = params
        self._on, self._against = 0.0, 0.0

    @property
    def agreement(self) -> float:
        """Share of the beams that say something which lie on the map's walls."""
        return self._on / max(self._on + self._against, 1e-9)

    @property
    def beams_on_walls(self) -> float:
        """Of a scan, of late."""
        return (1.0 - self._params.agreement_keep) * self._on

    def step(self, filter_: MonteCarloLocalization, scan: LaserScan, reckoned: Array) -> MonteCarloEstimate:
        """Moves the particles and weighs them by the scan."""
        params, field = self._params, filter_.field
        estimate, self.state = filter_.step(self.state, scan.ranges_m, scan.angles_rad, reckoned)
        points = filter_.beam_ends(scan.ranges_m, scan.angles_rad)
        counts = counted_beams(
            points,
            estimate.pose_map,
            field.hit,
            field.origin_x_m,
            field.origin_y_m,
            field.cell_m,
            params.clear_m,
        )
        against = counts[THROUGH_WALL] + counts[BESIDE_MAP] + params.short_weight * counts[SHORT]
        self._on = params.agreement_keep * self._on + float(counts[ON_WALL])
        self._against = params.agreement_keep * self._against + float(against)
        return estimate


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
        self.tracked: _Hypothesis | None = None
        self._other: _Hypothesis | None = None
        self._window = FieldWindow(tiles, self.params.monte_carlo.field, self.params.around)
        self._mount, self._mount_back = T_base_laser, inverse(T_base_laser)
        self._seed = seed
        self._reckoned: DeadReckoningState | None = None
        self._astray, self._doubted, self._better, self._fresh = 0, 0, 0, 0
        self._disc: tuple[LikelihoodField, LikelihoodField, float, float] | None = None

    def step(self, scan: LaserScan, job: LocalizationJob) -> ScanAnswer:
        """Where the vehicle was at the scan's stamp; job: what was known of it besides, then."""
        params = self.params
        laser = _array(compose(job.pose_map, self._mount))
        reckoned = self._dead_reckoned(scan, job)
        field = self._field(laser)
        returns = int((np.isfinite(scan.ranges_m) & (scan.ranges_m > 0.0)).sum())
        if field is None or returns < params.beams_min:
            # Particles would drift without anything that holds them.
            self._forget()
            return ScanUnplaced(scan.stamp_ns, "no_map" if field is None else "too_little")
        filter_ = MonteCarloLocalization(field, params.monte_carlo)
        if self.tracked is None:
            self.tracked = _Hypothesis(self._started(filter_, scan, job, laser, reckoned), params)
        estimate = self.tracked.step(filter_, scan, reckoned)
        found = self._searched(filter_, scan, reckoned)
        self._fresh = self.params.better_scans if found is not None else max(0, self._fresh - 1)
        pose = self._scan_pose(scan.stamp_ns, found or estimate, returns)
        away_m = math.hypot(pose.pose_map.x_m - job.pose_map.x_m, pose.pose_map.y_m - job.pose_map.y_m)
        if away_m > self.params.overruled_m and self.tracked.beams_on_walls < self.params.overruling_beams:
            # It contradicts the vehicle's pose, and is too little to say another.
            pose = msgspec.structs.replace(pose, agreement=0.0, is_searched=False, through=1.0)
        if self._is_astray(away_m):
            self._forget()
        return pose

    def _forget(self) -> None:
        self.tracked = self._other = None
        self._doubted = self._better = self._astray = 0

    def _searched(
        self, filter_: MonteCarloLocalization, scan: LaserScan, reckoned: Array
    ) -> MonteCarloEstimate | None:
        """The estimate of other particles that have agreed much better for long enough to be believed."""
        params, tracked = self.params, self.tracked
        assert tracked is not None, "the other particles are compared with tracked ones"
        self._doubted = self._doubted + 1 if tracked.agreement < params.doubted else 0
        if self._doubted == 0:
            self._other, self._better = None, 0
            return None
        if self._doubted % params.search_rest_scans == params.doubted_scans:
            self._seed += 1
            started = filter_.anywhere(self._seed, scan.ranges_m, scan.angles_rad, reckoned)
            self._other, self._better = _Hypothesis(started, params), 0
        if self._other is None:
            return None
        estimate = self._other.step(filter_, scan, reckoned)
        is_better = (
            self._other.agreement > tracked.agreement + params.better
            and self._other.beams_on_walls >= params.overruling_beams
        )
        self._better = self._better + 1 if is_better else 0
        if self._better < params.better_scans:
            return None
        self.tracked, self._other = self._other, None
        self._doubted = self._better = 0
        return estimate

    def _dead_reckoned(self, scan: LaserScan, job: LocalizationJob) -> Array:
        """(3,) the laser since the first scan."""
        odometry = _array(compose(job.pose_odom, self._mount))
        output, self._reckoned = dead_reckoning.step(
            self._reckoned, scan.ranges_m, scan.angles_rad, odometry, self.params.dead_reckoning
        )
        return output.pose

    def _field(self, laser: Array) -> LikelihoodField | None:
        """The field, with the free cells around the prior alone; None where the map has none."""
        disc, x_m, y_m = self._disc, float(laser[0]), float(laser[1])
        field = self._window.around(x_m, y_m)
        if field is None:
            return None
        if (
            disc is not None
            and disc[0] is field
            and math.hypot(disc[2] - x_m, disc[3] - y_m) < self.params.search_again_m
        ):
            return disc[1]
        near = free_near(field, x_m, y_m, self.params.search_m)
        if not len(near.free):
            return None
        self._disc = (field, near, x_m, y_m)
        return near

    def _started(
        self,
        filter_: MonteCarloLocalization,
        scan: LaserScan,
        job: LocalizationJob,
        laser: Array,
        reckoned: Array,
    ) -> MonteCarloState:
        params = self.params
        self._seed += 1
        std_m = math.sqrt(max(job.covariance[0, 0], job.covariance[1, 1]))
        if std_m > params.start_std_m:
            return filter_.anywhere(self._seed, scan.ranges_m, scan.angles_rad, reckoned)
        std_rad = max(params.start_floor_rad, math.sqrt(job.covariance[2, 2]))
        return filter_.near(self._seed, laser, max(params.start_floor_m, std_m), std_rad, reckoned)

    def _is_astray(self, away_m: float) -> bool:
        """Whether the room has long not believed the particles: what it knows besides says another place."""
        self._astray = self._astray + 1 if away_m > self.params.astray_m else 0
        if self._astray < self.params.astray_scans:
            return False
        self._astray = 0
        return True

    def _scan_pose(self, stamp_ns: int, estimate: MonteCarloEstimate, returns: int) -> ScanPose:
        assert self.tracked is not None
        x_m, y_m, yaw_rad = (float(value) for value in estimate.pose_map)
        pose = compose(Pose2(x_m, y_m, yaw_rad), self._mount_back)
        # From the laser to the axle: the axle moves by the turn times the lever.
        lever = (pose.x_m - x_m, pose.y_m - y_m)
        moved = np.array([[1.0, 0.0, -lever[1]], [0.0, 1.0, lever[0]], [0.0, 0.0, 1.0]])
        covariance = moved @ estimate.covariance @ moved.T
        return ScanPose(
            stamp_ns,
            Pose2(pose.x_m, pose.y_m, wrap_angle(pose.yaw_rad)),
            0.5 * (covariance + covariance.T),
            self.tracked.agreement,
            returns,
            # Until the room has followed, it must not take the new place's agreement for the old one's.
            self._fresh > 0,
            1.0 - self.tracked.agreement,
        )


def _array(pose: Pose2) -> Array:
    return np.array([pose.x_m, pose.y_m, pose.yaw_rad])
