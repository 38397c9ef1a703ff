"""What finds road users in the scans of a vehicle's own lidars, built from the profile."""

from vehicle_agent.config import Body, Profile
from vehicle_agent.perception.own_tracks import TracksWorker
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.stacks.rooms import scan_thinning

# The lidars on the corners stand out by so much.
_OWN_M = 0.25


def tracks_worker(profile: Profile) -> TracksWorker:
    """Clusters, and for the Snow Lion the network, which has learned from its four lidars.

    Raises DetectorFileError.
    """
    network = detector(profile) if profile.stack == "snow_lion" else None
    return TracksWorker(point_perception(profile), network, scan_thinning(profile))


def point_perception(profile: Profile) -> PointPerception:
    """What finds cells, objects and tracks in the lidars' points, for the worker."""
    body = profile.body
    return PointPerception(
        PointGrid(
            above_m=body.height_m + 0.1,
            body_front_m=body.front_overhang_m,
            body_back_m=body.rear_overhang_m,
            body_half_width_m=0.5 * body.width_m,
        )
    )


def detector(profile: Profile) -> PillarDetector:
    """The network that ships, for the vehicle's outline. Raises DetectorFileError."""
    return PillarDetector(own_m=own_outline(profile.body))


def own_outline(body: Body) -> tuple[float, float, float]:
    """Rear, front and half width of what the network takes for the own body's returns, base frame.

    In training and on the vehicle alike.
    """
    rear_m, front_m, side_m = -body.rear_overhang_m, body.front_overhang_m, 0.5 * body.width_m
    return rear_m - _OWN_M, front_m + _OWN_M, side_m + _OWN_M
