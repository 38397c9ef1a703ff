"""What finds road users in the scans of a vehicle's own lidars, built from the profile."""

import contextlib
import math

import numpy as np

from vehicle_agent.config import Body, Profile
from vehicle_agent.perception.camera.people_detector import (
    CameraLibraryMissing,
    HogPeopleDetector,
    opencv,
)
from vehicle_agent.perception.laser_people.people import LaserPeople
from vehicle_agent.perception.own_tracks import NetworkFinder, TracksWorker
from vehicle_agent.perception.people_worker import PeopleFinder, PeopleWorker
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.tracking.below_beams import NearArea
from vehicle_agent.perception.tracking.tracker import ObjectTracker
from vehicle_agent.signals.pictures import PinholeCamera, optical_pose, pinhole_matrix
from vehicle_agent.stacks.rooms import scan_thinning

# The lidars on the corners stand out by so much.
_OWN_M = 0.25
# Nearer to the outline, the bonnet of a car is below the lowest beams.
_BLIND_M = 1.7
# So far before the bumper, and so far beside the body, all of a person may be below them.
_BELOW_AHEAD_M, _BELOW_ASIDE_M = 3.5, 1.0
# Of a person, no more than what is higher than this is in beams that pass there: too little for a cluster.
_HEAD_M = 1.35
# The middle of a person is no nearer to the flank; before the bumper it may lean over by half of that.
_HALF_PERSON_M = 0.2


def tracks_worker(profile: Profile, signs: SignFinder | None = None) -> TracksWorker:
    """Clusters; for the Snow Lion the network besides, which has learned from its four lidars.

    For a GEM or NUS vehicle with a planar scanner for people, that scanner and the camera (`lacking` says of
    what there is too little). signs: what reads signs in the same scans; None for a stack that reads none.
    Raises DetectorFileError.
    """
    points = point_perception(profile)
    if profile.stack != "snow_lion" and profile.people_scanner.rate_hz > 0.0:
        return PeopleWorker(points, people_finder(profile), scan_thinning(profile), signs)
    network = NetworkFinder(detector(profile)) if profile.stack == "snow_lion" else None
    return TracksWorker(points, network, scan_thinning(profile), signs)


def people_finder(profile: Profile) -> PeopleFinder:
    """Laser and camera of the profile; without OpenCV or a camera the laser alone."""
    scanner = profile.people_scanner
    cos, sin = math.cos(scanner.yaw_rad), math.sin(scanner.yaw_rad)
    T_base_laser = np.array(
        [[cos, -sin, 0.0, scanner.x_m], [sin, cos, 0.0, scanner.y_m], [0.0, 0.0, 1.0, scanner.z_m],
         [0.0, 0.0, 0.0, 1.0]]
    )  # fmt: skip
    scorer = None
    if profile.camera.rate_hz > 0.0:
        with contextlib.suppress(CameraLibraryMissing):
            scorer = HogPeopleDetector()
    return PeopleFinder(
        LaserPeople(), T_base_laser, scanner.field_rad, scanner.step_rad, pinhole_camera(profile), scorer
    )


def pinhole_camera(profile: Profile) -> PinholeCamera:
    """The profile's camera, as pictures are compared with it."""
    camera = profile.camera
    return PinholeCamera(
        "front",
        pinhole_matrix(camera.width_px, camera.height_px, camera.field_rad),
        optical_pose(camera.x_m, camera.y_m, camera.z_m, camera.yaw_rad, camera.down_rad),
        camera.width_px,
        camera.height_px,
    )


def lacking(profile: Profile) -> str:
    """What own perception does without in this installation, as a sentence for an operator; "": nothing."""
    scanner, camera = profile.people_scanner, profile.camera
    if profile.perception != "own":
        return ""
    if profile.stack == "snow_lion":
        if scanner.rate_hz > 0.0:
            return (
                f"the [people_scanner] of {profile.name} is not used: this stack finds people by its lidars"
            )
        return ""
    if scanner.rate_hz <= 0.0:
        return f"{profile.name} has no [people_scanner]: who is below the beams of its lidar is not seen"
    if camera.rate_hz <= 0.0:
        # The GEM paper's camera looks at no people.
        if profile.stack == "gem":
            return ""
        return f"{profile.name} has no [camera]: no picture verifies who is a person"
    try:
        opencv()
    except CameraLibraryMissing as error:
        return f"no picture verifies who is a person, laser and lidar find road users alone: {error}"
    return ""


def point_perception(profile: Profile) -> PointPerception:
    """What finds cells, objects and tracks in the lidars' points, for the worker."""
    body, lidar = profile.body, profile.lidar
    half_m = 0.5 * body.width_m
    steepest = math.tan(max(-lidar.elevation_rad_min, 0.01))
    return PointPerception(
        PointGrid(
            above_m=body.height_m + 0.1,
            body_front_m=body.front_overhang_m,
            body_back_m=body.rear_overhang_m,
            body_half_width_m=half_m,
        ),
        tracker=ObjectTracker(
            blind_m=(-body.rear_overhang_m - _BLIND_M, body.front_overhang_m + _BLIND_M, half_m + _BLIND_M),
            below_beams=NearArea(
                begin_m=-body.rear_overhang_m,
                bumper_m=body.front_overhang_m + 0.5 * _HALF_PERSON_M,
                end_m=body.front_overhang_m + _BELOW_AHEAD_M,
                half_width_m=half_m + _HALF_PERSON_M,
                side_m=half_m + _BELOW_ASIDE_M,
            ),
        ),
        unseen_m=(lidar.x_m, max(lidar.z_m - _HEAD_M, 0.0) / steepest),
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
