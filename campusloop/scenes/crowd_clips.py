"""Scenes from drone recordings: the shuttle drives a recorded car's path among the recorded people."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import msgspec
import numpy as np

from campusloop.scenes.contact_metrics import ContactMetrics, contact_metrics
from campusloop.scenes.drive import Scene
from campusloop.scenes.path_map import extended, path_map
from campusloop.scenes.people_met import PeopleMet, people_met
from campusloop.scenes.recorded.drives import RecordedDrive, rear_axle_path, recorded_drives
from contract.geometry import arc_lengths
from simulator.traffic.actors import Bodies
from simulator.traffic.aware.reproduction import Reproduction, reproduction
from simulator.traffic.aware.traffic import AwareTraffic
from simulator.traffic.recordings import CARS_FROM, Clip, RecordedTrack
from simulator.traffic.replayed import ReplayedTraffic
from vehicle_agent.config import Body, Profile

# `recorded` people see nothing; `aware` people heed the shuttle as they heeded the car.
People = Literal["recorded", "aware"]
PEOPLE: tuple[People, ...] = get_args(People)
TIMES_HUMAN_MAX = 2.0
_BEFORE_M, _AFTER_M = 12.0, 30.0
_WIDTH_M = 4.0
_LATERAL_MPS2 = 2.0


@dataclass(frozen=True, slots=True)
class ClipRun:
    """A scene with its people, and the recorded human drive evaluated by the same metrics."""

    scene: Scene
    traffic: ReplayedTraffic | AwareTraffic
    drive: RecordedDrive
    human: ContactMetrics
    human_met: PeopleMet

    @property
    def human_time_s(self) -> float:
        return self.drive.time_s

    @property
    def human_max_mps(self) -> float:
        return self.drive.speed_mps_max

    def reproduction(self, clip: Clip, body: Body) -> Reproduction:
        """How people of the model walk with the car's own motion in the shuttle's place."""
        half_m = 0.5 * body.length_m
        return reproduction(clip, self.drive.car, (half_m, half_m, 0.5 * body.width_m))


def clip_runs(clip: Clip, profile: Profile, seed: int, people: People = "recorded") -> list[ClipRun]:
    """One run for each recorded drive of the clip; the speed limit is the car's own maximum."""
    return [
        _run(
            clip,
            drive,
            f"{clip.name}-car{car.number - CARS_FROM}{f'-drive{k}' if k else ''}",
            profile,
            seed,
            people,
        )
        for car in clip.cars()
        for k, drive in enumerate(recorded_drives(car))
    ]


def _run(clip: Clip, drive: RecordedDrive, name: str, profile: Profile, seed: int, people: People) -> ClipRun:
    body, car = profile.body, drive.car
    path = rear_axle_path(drive, body)
    whole = extended(path, _BEFORE_M, _AFTER_M)
    cap_mps = drive.speed_mps_max
    limits = msgspec.structs.replace(
        profile.limits,
        speed_mps_max=cap_mps,
        lateral_accel_mps2_max=max(profile.limits.lateral_accel_mps2_max, _LATERAL_MPS2),
    )
    length_m = float(arc_lengths(path)[-1])
    before_m = math.ceil(_BEFORE_M)
    kind = AwareTraffic if people == "aware" else ReplayedTraffic
    traffic = kind(clip, float(car.times_s[0]), _pieces(clip, car))
    scene = Scene(
        name=name,
        road_map=path_map(name, whole, width_m=_WIDTH_M, speed_limit_mps=cap_mps),
        profile=msgspec.structs.replace(profile, limits=limits),
        start_s_m=float(before_m),
        start_mps=float(np.hypot(car.states[0, 3], car.states[0, 4])),
        goal_s_m=before_m + length_m,
        limit_s=TIMES_HUMAN_MAX * drive.time_s,
        seed=seed,
        actors=traffic,
    )
    return ClipRun(scene, traffic, drive, *_human(clip, car, body))


def _pieces(clip: Clip, car: RecordedTrack) -> frozenset[int]:
    """The numbers of the car's tracks: several if its recording breaks off in between."""
    return frozenset(other.number for other in clip.cars() if other.recorded_id == car.recorded_id)


def _human(clip: Clip, car: RecordedTrack, body: Body) -> tuple[ContactMetrics, PeopleMet]:
    """The metrics of the recorded drive, with the shuttle's outline about the car's centre."""
    others = ReplayedTraffic(clip, float(car.times_s[0]), _pieces(clip, car))
    back_m = 0.5 * body.length_m - body.rear_overhang_m
    rows, agents = [], list[Bodies]()
    for t, (x, y, yaw, vx, vy) in zip(car.times_s, car.states, strict=True):
        others.clock_s = float(t)
        rows.append(
            (t, x - back_m * math.cos(yaw), y - back_m * math.sin(yaw), yaw, math.hypot(vx, vy), 0.0, 0.0)
        )
        agents.append(others.bodies())
    table = np.array(rows)
    return contact_metrics(table, agents, body), people_met(table, agents, body)
