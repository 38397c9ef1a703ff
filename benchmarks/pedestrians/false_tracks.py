"""Tracks that are no people: a drive among trees that sway, with no people about."""

import numpy as np

from benchmarks.pedestrians.scenes import PeopleDrive, states_of
from benchmarks.reporting.report import Row
from contract.roads.model import RoadMap
from simulator.sensors.cameras.light import OVERCAST
from simulator.sensors.cameras.mounts import CameraMount
from simulator.sensors.scene.static_scene import StaticScene
from vehicle_agent.config import Body
from vehicle_agent.perception.camera.people_detector import HogPeopleDetector
from vehicle_agent.perception.laser_people.people import LaserPeople

_DRIVE_S = 10.0
_SPEED_MPS = 2.0


def false_row(
    road_map: RoadMap,
    scene: StaticScene,
    body: Body,
    front: CameraMount,
    minutes: float,
    seed: int,
    with_pictures: bool = True,
) -> Row:
    """One row: labelled and moving tracks per minute, and the mean of those that were followed.

    with_pictures  False: the laser alone, of which labels say nothing; thirty times as fast
    """
    room, detector = LaserPeople(), HogPeopleDetector() if with_pictures else None
    labelled = moving = 0
    followed: list[int] = []
    drives = max(1, round(60.0 * minutes / _DRIVE_S))
    for number in range(drives):
        drive = PeopleDrive(
            road_map, scene, body, front, OVERCAST, seed + number, 0, _SPEED_MPS, _DRIVE_S, with_pictures
        )
        people: set[int] = set()
        movers: set[int] = set()
        for _, state in states_of(drive, room, detector):
            tracks = state.tracks
            people |= set(tracks.ids[tracks.is_person].tolist())
            movers |= set(tracks.ids[tracks.has_moved].tolist())
            followed.append(int(room.tracker.is_followed(tracks).sum()))
        labelled += len(people)
        moving += len(movers)
    driven_min = drives * _DRIVE_S / 60.0
    return {
        "part": "false",
        "case": f"{driven_min:.2g} min among trees" + ("" if with_pictures else ", laser alone"),
        "false_per_min": labelled / driven_min if with_pictures else None,
        "moving_per_min": moving / driven_min,
        "followed_mean": float(np.mean(followed)),
    }
