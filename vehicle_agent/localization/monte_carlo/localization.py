"""Adaptive Monte-Carlo localization of a planar laser in an occupancy map.

Each scan moves the particles by odometry and weighs them by the likelihood field. KLD-sampling sets their
number. Where the scans fit worse than they used to, some particles start anew (augmented MCL, Thrun et al.
2005, 8.3.3). Where the pose is lost for long, the whole map is searched. The room draws from a generator that
is part of its state.
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array, IntArray
from contract.occupancy.occupancy_map import FREE, OccupancyMap
from vehicle_agent.localization.laser.pose_arrays import between, composed, wrapped
from vehicle_agent.localization.monte_carlo.beam_support import supported
from vehicle_agent.localization.monte_carlo.global_search import GlobalSearchParams, global_poses
from vehicle_agent.localization.monte_carlo.likelihood_field import (
    FieldParams,
    LikelihoodField,
    likelihood_field,
)
from vehicle_agent.localization.monte_carlo.particles import (
    climb,
    kld_resampled,
    mean_over_beams,
    move,
    uniform_poses,
)
from vehicle_agent.localization.monte_carlo.random_numbers import GeneratorState, generator, uniform


class MapUnusable(ValueError):
    """No pose can be found in the map; the message says why."""


class MonteCarloParams(msgspec.Struct, frozen=True):
    """The filter.

    range_m_max          longer beams are left out
    support_m, support_slope  a reading counts if one of the next two on either side differs by no more than
                         this and this much of the way between their ends: a broken one stands alone
    beams_max            evenly chosen beams of a scan that are weighed
    independent_beams    as how many independent ones they count: neighbours see the same wall
    standing_m, standing_rad  where odometry moved less than this, a scan is nearly the same evidence again
    standing_evidence    share of its evidence that is new
    settled_lost         a pose less likely lost than this needs no scan while it stands
    step_std_m, step_std_rad  noise of a step of odometry, at least
    way_ratio, turn_ratio, turn_radpm  and this share of its length, of its turn, and this turn for each metre
    slip_ratio, slip_m, slip_rad  share of the steps that are off by more, and their noise
    matched, matched_copies  so many particles are drawn to the scan's walls, and copied: odometry that is
                         off by more than its noise does not lose the pose
    match_m, match_rad   first step of that search
    matched_std_m, matched_std_rad  noise of the copies
    particles_min, particles_max
    kld_error, kld_quantile, bin_m, bin_rad  of KLD-sampling
    effective_ratio      resample where the effective number of particles falls below this share
    cluster_m, cluster_rad    particles this near to the densest place make the estimate
    fit_fast, fit_slow   shares by which the two averages of the fit follow it, for one scan
    fit_lost, fit_lost_width  the fit at which the pose is as likely lost as not, and how sharply that turns
    start_anew_max       greatest share of particles that start anew after one scan
    lost_scans_max       after so many scans in a row at which the pose is rather lost, the map is searched:
                         soon, before the particles settle in a place that only looks alike
    search_rest_scans    scans from one search to the next, at least
    covariance_ratio     of the estimate to that of the cluster, which the noise of slipping makes broad
    position_floor_m, yaw_floor_rad  standard deviation that no scan takes away: cells, the map's error
    """

    field: FieldParams = FieldParams()
    search: GlobalSearchParams = GlobalSearchParams()
    range_m_max: float = 30.0
    support_m: float = 0.1
    support_slope: float = 4.0
    beams_max: int = 90
    independent_beams: float = 30.0
    standing_m: float = 0.01
    standing_rad: float = 0.009
    settled_lost: float = 0.05
    standing_evidence: float = 0.05
    step_std_m: float = 0.01
    step_std_rad: float = 0.005
    way_ratio: float = 0.15
    turn_ratio: float = 0.15
    turn_radpm: float = 0.07
    slip_ratio: float = 0.2
    slip_m: float = 0.12
    slip_rad: float = 0.09
    matched: int = 6
    matched_copies: int = 5
    match_m: float = 0.12
    match_rad: float = 0.05
    matched_std_m: float = 0.03
    matched_std_rad: float = 0.012
    particles_min: int = 500
    particles_max: int = 5000
    kld_error: float = 0.05
    kld_quantile: float = 2.33
    bin_m: float = 0.5
    bin_rad: float = 0.26
    effective_ratio: float = 0.5
    cluster_m: float = 0.6
    cluster_rad: float = 0.35
    fit_fast: float = 0.3
    fit_slow: float = 0.01
    fit_lost: float = 0.62
    fit_lost_width: float = 0.035
    start_anew_max: float = 0.1
    lost_scans_max: int = 3
    search_rest_scans: int = 20
    covariance_ratio: float = 0.25
    position_floor_m: float = 0.012
    yaw_floor_rad: float = 0.005


class MonteCarloState(msgspec.Struct, frozen=True):
    """poses (n, 3), weights (n,) that sum to 1; random (4,) the generator; odometry (3,) at the last weighed
    scan; fit_fast, fit_slow averages of the fit, 0 before the first; lost_scans in a row,
    negative for as many scans as a search is not repeated."""

    poses: Array
    weights: Array
    random: GeneratorState
    odometry: Array
    fit_fast: float
    fit_slow: float
    lost_scans: int


class MonteCarloEstimate(msgspec.Struct, frozen=True):
    """Where the laser is.

    pose_map     (3,) mean of the densest cluster of particles
    covariance   (3, 3) of it (m2, rad2)
    lost         0..1: how likely the pose is another one altogether
    fit          0..1: mean nearness of the beams' ends to walls
    particles    how many there are
    """

    pose_map: Array
    covariance: Array
    lost: float
    fit: float
    particles: int


class MonteCarloLocalization(msgspec.Struct, frozen=True):
    """The map, as the filter uses it, and the filter's parameters."""

    field: LikelihoodField
    params: MonteCarloParams

    @classmethod
    def in_map(
        cls, occupancy: OccupancyMap, params: MonteCarloParams | None = None
    ) -> "MonteCarloLocalization":
        """Raises MapUnusable where the map has no free cell."""
        params = params or MonteCarloParams()
        if not (occupancy.cells == FREE).any():
            raise MapUnusable("The map has no free cell, so that no pose is possible.")
        return cls(likelihood_field(occupancy, params.field), params)

    def anywhere(self, seed: int, ranges_m: Array, angles_rad: Array, odometry: Array) -> MonteCarloState:
        """The state of a laser that may be anywhere in the map and sees this scan."""
        random = generator(seed)
        points = self.beam_ends(ranges_m, angles_rad)
        return _started(global_poses(points, self.field, self.params.search, random), random, odometry)

    def near(
        self, seed: int, pose_map: Array, std_m: float, std_rad: float, odometry: Array
    ) -> MonteCarloState:
        """The state of a laser that stands about there."""
        return started_near(self.params, seed, pose_map, std_m, std_rad, odometry)

    def step(
        self, state: MonteCarloState, ranges_m: Array, angles_rad: Array, odometry: Array
    ) -> tuple[MonteCarloEstimate, MonteCarloState]:
        """The estimate after one scan.

        ranges_m, angles_rad (m,) of the scan; what is no return is not finite or not positive
        odometry (3,) pose of the laser by the wheels, in any frame that stays; a scan whose odometry is not
        finite is left out
        """
        if not np.isfinite(odometry).all():
            # It would stay in the particles for ever.
            return self._estimate(state, np.zeros(3)), state
        way = between(state.odometry, odometry)
        length_m, turn_rad = math.hypot(way[0], way[1]), abs(float(way[2]))
        is_standing = length_m < self.params.standing_m and turn_rad < self.params.standing_rad
        if is_standing and state.fit_fast > 0.0:
            settled = self._estimate(state, way)
            if settled.lost < self.params.settled_lost:
                return settled, state
        params = self.params
        random = state.random.copy()
        poses = state.poses.copy()
        std_m = params.step_std_m + params.way_ratio * length_m
        std_rad = params.step_std_rad + params.turn_ratio * turn_rad + params.turn_radpm * length_m
        move(poses, way, std_m, std_rad, params.slip_ratio, params.slip_m, params.slip_rad, random)
        state = msgspec.structs.replace(state, poses=poses, random=random, odometry=np.asarray(odometry))
        points = self.beam_ends(ranges_m, angles_rad)
        if len(points):
            state = self._weighed(state, points, params.standing_evidence if is_standing else 1.0)
        estimate = self._estimate(state, np.zeros(3))
        lost_scans = state.lost_scans + 1 if estimate.lost > 0.5 or state.lost_scans < 0 else 0
        state = msgspec.structs.replace(state, lost_scans=lost_scans)
        if lost_scans > params.lost_scans_max and len(points):
            random = state.random.copy()
            found = global_poses(points, self.field, params.search, random)
            started = _started(found, random, state.odometry)
            return estimate, msgspec.structs.replace(started, lost_scans=-params.search_rest_scans)
        return estimate, self._resampled(state, points)

    def beam_ends(self, ranges_m: Array, angles_rad: Array) -> Array:
        """See `beam_ends`."""
        return beam_ends(ranges_m, angles_rad, self.params)

    def _weighed(self, state: MonteCarloState, points: Array, evidence: float) -> MonteCarloState:
        field, params = self.field, self.params
        place = (field.origin_x_m, field.origin_y_m, field.cell_m)
        state = self._with_matches(state, points)
        means = mean_over_beams(state.poses, points, field.log_likelihood, field.outside, *place)
        logs = np.log(state.weights) + evidence * min(params.independent_beams, len(points)) * means
        weights = np.exp(logs - logs.max())
        weights /= weights.sum()
        hits = mean_over_beams(state.poses, points, field.hit, 0.0, *place)
        fit = float(weights @ hits)
        first = state.fit_fast == 0.0
        fast = fit if first else state.fit_fast + params.fit_fast * (fit - state.fit_fast)
        slow = fit if first else state.fit_slow + params.fit_slow * (fit - state.fit_slow)
        return msgspec.structs.replace(state, weights=weights, fit_fast=max(fast, 1e-9), fit_slow=slow)

    def _with_matches(self, state: MonteCarloState, points: Array) -> MonteCarloState:
        """Some particles that weigh least give way to ones that the scan has drawn to its walls."""
        field, params = self.field, self.params
        random = state.random.copy()
        sums = np.cumsum(state.weights)
        drawn = np.array([uniform(random) for _ in range(params.matched)]) * sums[-1]
        matched = state.poses[np.minimum(np.searchsorted(sums, drawn), len(sums) - 1)].copy()
        place = (field.outside, field.origin_x_m, field.origin_y_m, field.cell_m)
        for likelihoods in (field.coarse, field.log_likelihood):
            climb(matched, points, likelihoods, *place, params.match_m, params.match_rad)
        matched = np.repeat(matched, params.matched_copies, axis=0)
        move(matched, np.zeros(3), params.matched_std_m, params.matched_std_rad, 0.0, 0.0, 0.0, random)
        replaced = np.argsort(state.weights, kind="stable")[: len(matched)]
        poses, weights = state.poses.copy(), state.weights.copy()
        poses[replaced] = matched[: len(replaced)]
        weights[replaced] = 1.0 / len(weights)
        return msgspec.structs.replace(state, poses=poses, weights=weights / weights.sum(), random=random)

    def _resampled(self, state: MonteCarloState, points: Array) -> MonteCarloState:
        params = self.params
        effective = 1.0 / float(state.weights @ state.weights)
        anew = 0.0
        if state.fit_slow > 0.0 and state.fit_fast < params.fit_lost:
            anew = min(max(0.0, 1.0 - state.fit_fast / state.fit_slow), params.start_anew_max)
        if effective > params.effective_ratio * len(state.weights) and anew == 0.0:
            return state
        random = state.random.copy()
        poses = kld_resampled(
            state.poses,
            state.weights,
            params.bin_m,
            params.bin_rad,
            params.kld_error,
            params.kld_quantile,
            params.particles_min,
            params.particles_max,
            random,
        )
        count = int(anew * len(poses))
        if count and len(points) and len(self.field.free):
            poses[len(poses) - count :] = self._anew(count, points, random)
        weights = np.full(len(poses), 1.0 / len(poses))
        return msgspec.structs.replace(state, poses=poses, weights=weights, random=random)

    def _anew(self, count: int, points: Array, random: GeneratorState) -> Array:
        """(count, 3) the best of ten times as many poses from anywhere."""
        field = self.field
        tried = uniform_poses(field.free, 10 * count, field.cell_m, random)
        scores = mean_over_beams(
            tried, points, field.coarse, field.outside, field.origin_x_m, field.origin_y_m, field.cell_m
        )
        best: Array = tried[np.argsort(-scores, kind="stable")[:count]]
        return best

    def _estimate(self, state: MonteCarloState, way: Array) -> MonteCarloEstimate:
        """Of the densest cluster; `way` is what odometry has moved since the particles were."""
        params = self.params
        pose, share, covariance = _cluster(state, params)
        lost_by_fit = 1.0 / (1.0 + math.exp((state.fit_fast - params.fit_lost) / params.fit_lost_width))
        return MonteCarloEstimate(
            composed(pose, way),
            params.covariance_ratio * covariance
            + np.diag([params.position_floor_m**2] * 2 + [params.yaw_floor_rad**2]),
            1.0 - share * (1.0 - lost_by_fit),
            state.fit_fast,
            len(state.poses),
        )


def started_near(
    params: MonteCarloParams, seed: int, pose_map: Array, std_m: float, std_rad: float, odometry: Array
) -> MonteCarloState:
    """The state of a laser that stands about a pose (3,), with these standard deviations."""
    random = generator(seed)
    poses = np.tile(np.asarray(pose_map, dtype=np.float64), (params.particles_min, 1))
    move(poses, np.zeros(3), std_m, std_rad, 0.0, 0.0, 0.0, random)
    return _started(poses, random, odometry)


def beam_ends(ranges_m: Array, angles_rad: Array, params: MonteCarloParams) -> Array:
    """(k, 2) ends of evenly chosen beams in the laser's frame, in order of their angles."""
    seen = supported(ranges_m, angles_rad, params.range_m_max, params.support_m, params.support_slope)
    if len(seen) > params.beams_max:
        seen = seen[np.linspace(0, len(seen) - 1, params.beams_max).astype(np.int64)]
    ranges_m, angles_rad = ranges_m[seen], angles_rad[seen]
    return np.stack([ranges_m * np.cos(angles_rad), ranges_m * np.sin(angles_rad)], axis=1)


def _started(poses: Array, random: GeneratorState, odometry: Array) -> MonteCarloState:
    weights = np.full(len(poses), 1.0 / len(poses))
    return MonteCarloState(poses, weights, random, np.asarray(odometry, dtype=np.float64), 0.0, 0.0, 0)


def _cluster(state: MonteCarloState, params: MonteCarloParams) -> tuple[Array, float, Array]:
    """(mean pose (3,), weight, covariance (3, 3)) of the particles around the heaviest bin."""
    poses, weights = state.poses, state.weights
    bins = np.floor(poses / np.array([params.cluster_m, params.cluster_m, params.cluster_rad])).astype(
        np.int64
    )
    of, first = _grouped(bins)
    heaviest = int(np.argmax(np.bincount(of, weights=weights)))
    pose = poses[first[heaviest]]
    inside = of == heaviest
    for _ in range(3):
        share = float(weights[inside].sum())
        chosen, chosen_weights = poses[inside], weights[inside] / share
        away = np.stack(
            [chosen[:, 0] - pose[0], chosen[:, 1] - pose[1], wrapped(chosen[:, 2] - pose[2])], axis=1
        )
        mean = chosen_weights @ away
        pose = np.array([pose[0] + mean[0], pose[1] + mean[1], math.remainder(pose[2] + mean[2], math.tau)])
        near = np.hypot(poses[:, 0] - pose[0], poses[:, 1] - pose[1]) < params.cluster_m
        inside = near & (np.abs(wrapped(poses[:, 2] - pose[2])) < params.cluster_rad)
        if not inside.any():
            break
    away -= mean
    # Not a matrix product: that would wake the threads of the linear algebra library for 500 rows.
    return pose, share, np.einsum("ia,i,ib->ab", away, chosen_weights, away)


def _grouped(bins: IntArray) -> tuple[IntArray, IntArray]:
    """(group of each row, first row of each group) of equal rows (n, 3)."""
    low = bins.min(axis=0)
    spans = bins.max(axis=0) - low + 1
    keys = ((bins[:, 0] - low[0]) * spans[1] + bins[:, 1] - low[1]) * spans[2] + bins[:, 2] - low[2]
    _, first, of = np.unique(keys, return_index=True, return_inverse=True)
    return of.astype(np.int64), first.astype(np.int64)
