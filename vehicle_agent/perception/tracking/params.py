"""Parameters of the tracker."""

import math
from typing import NamedTuple

from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE


class KindMotion(NamedTuple):
    """How a kind moves and how well it is measured.

    accel_mps2        standard deviation of acceleration: going on steadily, and starting, stopping or turning
    turn_radps2       the same of the turn rate's change; 0: goes straight
    position_std_m    of a measured middle; and per metre of distance
    speed_std_mps     of a new track without a measured velocity
    velocity_std_mps  of velocities that a finder measures, scan after scan
    agree_mps         one that is farther from the track's own has doubted_mps in its place
    doubted_mps       standard deviation of those that disagree
    reach_m           a measurement farther from the expected place is another object's
    """

    accel_mps2: tuple[float, float]
    turn_radps2: tuple[float, float]
    position_std_m: float
    position_std_per_m: float
    speed_std_mps: float
    velocity_std_mps: float
    agree_mps: float
    doubted_mps: float
    reach_m: float


class TrackerParams(NamedTuple):
    """Counts are scans.

    motions          by kind, in the order of TRACK_KINDS
    stay             probability that a model of motion goes on for a scan
    gate             largest squared Mahalanobis distance of a track's measurement (99.97 % of its own)
    touching_m       a track and an object that both are left over, touch and lie so near are one
    kind_cost        added to it where the kinds differ
    confirm_hits, confirm_scans   a track is shown after so many hits in its first scans
    tentative_misses a new track ends after so many misses
    coast_scans      a missed track goes on for so long where nothing hides it
    hidden_scans     and for so long where something nearer does
    shown_scans, shown_share   a missed track is shown for so long, and at most for this share of its hits
    person_mps_max   what moves faster is no pedestrian
    forget           share of the evidence of kinds that is left after a scan
    born_std_mps     of the measured velocity with which a track begins
    fitted_std_m     of the middle of a box that is fitted to returns, whatever its kind and distance
    score_min        objects with a lower score begin no track
    other_m_max      longest thing of no kind that becomes a track when it moves
    moved_m          and how far it must have moved
    still            squared deviation at which a velocity counts half: jitter of what stands is smaller
    top_only_m       of a person no more than this height was seen last: the beams pass over the rest
    below_drift      a person who then vanishes before the bumper stays there; share of their velocity that
                     is left after each scan
    below_reach_m, below_mps  who appears at the area's bounds without a track is them, if no farther away
                     than below_reach_m and this speed times the time unseen
    gap_s_max        after a longer gap all tracks end but those of people below the beams
    """

    motions: tuple[KindMotion, ...] = ()
    stay: float = 0.93
    gate: float = 16.0
    touching_m: float = 1.5
    kind_cost: float = 4.0
    confirm_hits: int = 3
    confirm_scans: int = 5
    tentative_misses: int = 2
    coast_scans: int = 5
    hidden_scans: int = 20
    shown_scans: int = 10
    shown_share: float = 0.3
    person_mps_max: float = 3.2
    forget: float = 0.9
    born_std_mps: float = 0.4
    fitted_std_m: float = 0.06
    score_min: float = 0.25
    other_m_max: float = 1.2
    moved_m: float = 1.2
    still: float = 1.0
    top_only_m: float = 0.4
    below_drift: float = 0.8
    below_reach_m: float = 1.0
    below_mps: float = 1.5
    gap_s_max: float = 1.0


_MOTIONS = {
    PEDESTRIAN: KindMotion((1.0, 5.0), (0.0, 0.0), 0.06, 0.0, 1.2, 0.25, 1.0, 2.0, 1.5),
    CYCLIST: KindMotion((0.5, 5.0), (0.1, 1.5), 0.12, 0.004, 3.0, 0.4, math.inf, 0.4, 2.5),
    VEHICLE: KindMotion((0.4, 4.0), (0.05, 0.5), 0.2, 0.004, 4.0, 0.4, math.inf, 0.4, 3.5),
    OTHER: KindMotion((0.2, 2.0), (0.0, 0.0), 0.12, 0.004, 0.8, 0.4, math.inf, 0.4, 1.5),
}
DEFAULT_PARAMS = TrackerParams(motions=tuple(_MOTIONS[kind] for kind in sorted(_MOTIONS)))
# Evidence never grows beyond this, so that a kind can change.
EVIDENCE_MAX = math.log(1e4)
