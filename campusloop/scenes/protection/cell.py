"""One protection cell: a target that meets the shuttle's front if nobody brakes."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from campusloop.scenes.drive import Scene
from campusloop.scenes.path_map import path_map
from contract.geometry import Array, arc_lengths, pose_at
from simulator.sensors.tracker import TrackerNoise
from simulator.traffic.recordings import Clip, RecordedTrack
from simulator.traffic.replayed import ReplayedTraffic
from simulator.traffic.scripted_clips import SIZES_M, walker
from simulator.world import WorldOptions
from vehicle_agent.config import Body, Profile

KMH = 1.0 / 3.6
SHARES = (0.25, 0.5, 0.75)
RANGES_M = {"day": 45.0, "night": 20.0}
BEFORE_S = 5.0
SCOOTER_SIZE_M = (1.2, 0.5)
TARGET, PARKED = 1, 100
_RUN_UP_M, _RUN_OUT_M = 14.0, 40.0


@dataclass(frozen=True, slots=True)
class Cell:
    """path (n, 2): of the rear axle; meet_s_m: the rear axle's position at the contact without braking.

    harmless_s: until then nothing shows what the target will do, and nobody would brake for it
    """

    name: str
    kind: str
    light: str
    speed_mps: float
    path: Array
    start_s_m: float
    meet_s_m: float
    clip: Clip
    harmless_s: float = 0.0

    def scene(self, profile: Profile, seed: int) -> Scene:
        """The shuttle drives towards the contact at the cell's speed, which is also its speed limit."""
        limits = msgspec.structs.replace(profile.limits, speed_mps_max=self.speed_mps)
        return Scene(
            name=self.name,
            road_map=path_map(self.name, self.path, width_m=3.5, speed_limit_mps=self.speed_mps),
            profile=msgspec.structs.replace(profile, limits=limits),
            start_s_m=self.start_s_m,
            start_mps=self.speed_mps,
            goal_s_m=self.meet_s_m + 10.0,
            limit_s=(self.meet_s_m - self.start_s_m) / self.speed_mps + 20.0,
            seed=seed,
            actors=ReplayedTraffic(self.clip, 0.0),
            options=WorldOptions(traffic=None, tracker=TrackerNoise(range_m_max=RANGES_M[self.light])),
        )


def straight(speed_mps: float, before_s: float = BEFORE_S) -> tuple[Array, float, float]:
    """(path, start, position of the contact after before_s): the vehicle drives along x."""
    meet_s_m = _RUN_UP_M + speed_mps * before_s
    x = np.arange(0.0, meet_s_m + _RUN_OUT_M, 1.0)
    path: Array = np.column_stack((x, np.zeros(len(x))))
    return path, _RUN_UP_M, meet_s_m


def crosser(
    body: Body,
    path: Array,
    meet_s_m: float,
    side: float,
    share: float,
    kind: int,
    target_mps: float,
    size_m: tuple[float, float] | None = None,
    way_m_max: float = 25.0,
) -> RecordedTrack:
    """A target that crosses the path at a right angle and is at `share` of the front's width at the contact.

    share is measured from the side that the target comes from. The target stands until it has to walk
    way_m_max to the contact.
    """
    s = arc_lengths(path)
    x_m, y_m, yaw_rad = pose_at(path, s, meet_s_m)
    length_m = (size_m or SIZES_M[kind])[0]
    ahead_m = body.front_overhang_m + 0.5 * (size_m or SIZES_M[kind])[1]
    front = np.array([x_m + ahead_m * math.cos(yaw_rad), y_m + ahead_m * math.sin(yaw_rad)])
    left = np.array([-math.sin(yaw_rad), math.cos(yaw_rad)])
    offset_m = side * (0.5 - share) * body.width_m
    met = front + offset_m * left
    way_m = min(target_mps * BEFORE_S, way_m_max)
    begins_s = BEFORE_S - way_m / target_mps
    begin = met + side * way_m * left
    end = met - side * (8.0 + length_m) * left
    places = ((float(begin[0]), float(begin[1])), (float(end[0]), float(end[1])))
    return walker(TARGET, kind, places, target_mps, begins_s, size_m)
