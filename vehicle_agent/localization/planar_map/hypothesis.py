"""Particles that may be right, and how the scans of late speak for them."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.monte_carlo.likelihood_field import LikelihoodField
from vehicle_agent.localization.monte_carlo.localization import (
    MonteCarloEstimate,
    MonteCarloLocalization,
    MonteCarloState,
)
from vehicle_agent.localization.monte_carlo.particles import climb
from vehicle_agent.localization.planar_map.agreement import Evidence, EvidenceParams, evidence_at, things_of
from vehicle_agent.signals.laser_scan import LaserScan


class RecentEvidence:
    """What the last scans say of a pose that moves with the vehicle, on average."""

    def __init__(self, params: EvidenceParams, keep: float) -> None:
        """keep: share that stays from one scan to the next."""
        self._params, self._keep = params, keep
        self._on, self._against, self._things, self._sum = 0.0, 0.0, 0.0, 0.0

    @property
    def of_a_scan(self) -> Evidence:
        total = max(self._sum, 1e-9)
        return Evidence(self._on / total, self._against / total, self._things / total)

    @property
    def agreement(self) -> float:
        return self.of_a_scan.agreement(self._params.prior)

    def add(self, points: Array, pose: Array, field: LikelihoodField) -> None:
        """points (m, 2): ends of a scan's beams, laser frame; pose (3,) of the laser in the map frame"""
        found, keep = (
            evidence_at(points, things_of(points, self._params), pose, field, self._params),
            self._keep,
        )
        self._on = keep * self._on + found.on
        self._against = keep * self._against + found.against
        self._things = keep * self._things + found.things_on_walls
        self._sum = keep * self._sum + 1.0


class Hypothesis:
    """One place of the vehicle: its particles and its evidence."""

    def __init__(self, state: MonteCarloState, evidence: EvidenceParams, keep: float) -> None:
        """keep: see `RecentEvidence`."""
        self.state = state
        self.scans = 0
        self._recent = RecentEvidence(evidence, keep)

    @property
    def evidence(self) -> Evidence:
        return self._recent.of_a_scan

    @property
    def agreement(self) -> float:
        return self._recent.agreement

    def step(self, filter_: MonteCarloLocalization, scan: LaserScan, reckoned: Array) -> MonteCarloEstimate:
        """Moves the particles and weighs them by the scan."""
        estimate, self.state = filter_.step(self.state, scan.ranges_m, scan.angles_rad, reckoned)
        points = filter_.beam_ends(scan.ranges_m, scan.angles_rad)
        self._recent.add(points, estimate.pose_map, filter_.field)
        self.scans += 1
        return estimate


class Candidate(msgspec.Struct, frozen=True):
    """A place that a search has found: pose (3,) of the laser in the map frame, and its evidence."""

    pose: Array
    evidence: Evidence

    @property
    def balance(self) -> float:
        return self.evidence.balance


def refined(
    pose: Array, points: Array, filter_: MonteCarloLocalization, evidence: EvidenceParams
) -> Candidate:
    """The pose (3,) moved uphill, and what the scan's beam ends (m, 2), laser frame, say of it."""
    field, params = filter_.field, filter_.params
    poses = np.asarray(pose, dtype=np.float64)[None].copy()
    place = (field.outside, field.origin_x_m, field.origin_y_m, field.cell_m)
    for likelihoods in (field.coarse, field.log_likelihood):
        climb(poses, points, likelihoods, *place, params.match_m, params.match_rad)
    found = evidence_at(points, things_of(points, evidence), poses[0], field, evidence)
    return Candidate(poses[0], found)


def is_apart(one: Array, other: Array, apart_m: float, apart_rad: float) -> bool:
    """Whether two poses (3,) are two places."""
    turn_rad = abs(math.remainder(float(one[2] - other[2]), math.tau))
    return math.hypot(one[0] - other[0], one[1] - other[1]) > apart_m or turn_rad > apart_rad
