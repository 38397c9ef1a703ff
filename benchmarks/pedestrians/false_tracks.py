"""Tracks that are no people: a drive among trees that sway, with no people about."""

import numpy as np

from benchmarks.pedestrians.scenes import PeopleDrive
from benchmarks.reporting.report import Row
from contract.roads.model import RoadMap
from simulator.sensors.cameras.light import OVERCAST
from simulator.sensors.cameras.mounts import CameraMount
from simulator.sensors.scene.static_scene import StaticScene
from vehicle_agent.config import Body
from vehicle_agent.perception.camera.people_detector import HogPeopleDetector
from vehicle_agent.perception.laser_people.people import LaserPeople, LaserPeopleState

_DRIVE_S = 10.0
_SPEED_MPS = 2.0


def false_row(
    road_map: RoadMap, scene: StaticScene, body: Body, front: CameraMount, minutes: float, seed: int
) -> Row:
    """One row: labelled and moving tracks per minute, and the most and the mean that were followed."""
    room, detector = LaserPeople(), HogPeopleDetector()
    labelled = moving = 0
    followed: list[int] = []
    drives = max(1, round(60.0 * minutes / _DRIVE_S))
    for number in range(drives):
        drive = PeopleDrive(road_map, scene, body, front, OVERCAST, seed + number, 0, _SPEED_MPS, _DRIVE_S)
        state = LaserPeopleState()
        people: set[int] = set()
        movers: set[int] = set()
        for moment in drive.moments():
            scan = moment.scan
            state = room.after_scan(
                state,
                scan.ranges_m,
                scan.angles_rad,
                drive.laser.T_base_sensor,
                moment.pose_map,
                moment.stamp_ns,
            )
            if moment.shot is not None:
                state = room.after_picture(
                    state, moment.shot.picture, drive.camera.model, moment.pose_map, detector
                )
            tracks = state.tracks
            people |= set(tracks.ids[tracks.is_person].tolist())
            movers |= set(tracks.ids[room.is_moving(tracks) & room.tracker.is_followed(tracks)].tolist())
            followed.append(int(room.tracker.is_followed(tracks).sum()))
        labelled += len(people)
        moving += len(movers)
    driven_min = drives * _DRIVE_S / 60.0
    return {
        "part": "false",
        "case": f"{driven_min:.2g} min among trees",
        "false_per_min": labelled / driven_min,
        "moving_per_min": moving / driven_min,
        "followed_mean": float(np.mean(followed)),
    }
