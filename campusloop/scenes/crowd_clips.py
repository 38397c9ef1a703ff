"""Scenes from drone recordings: the shuttle drives a recorded car's path among the recorded people."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np
from scipy.interpolate import make_splrep

from campusloop.scenes.contact_metrics import ContactMetrics, contact_metrics
from campusloop.scenes.drive import Scene
from campusloop.scenes.path_map import extended, path_map
from contract.geometry import Array, arc_lengths
from simulator.traffic.actors import Bodies
from simulator.traffic.recordings import Clip, RecordedTrack
from simulator.traffic.replayed import ReplayedTraffic
from vehicle_agent.config import Body, Profile

# Cars with a lower mean speed are parked or waiting; they are obstacles.
DRIVING_MPS_MIN = 0.5
TIMES_HUMAN_MAX = 2.0
_BEFORE_M, _AFTER_M = 12.0, 30.0
_WIDTH_M = 4.0
_LATERAL_MPS2 = 2.0


@dataclass(frozen=True, slots=True)
class ClipRun:
    """A scene, and the recorded human drive: its time, maximum speed, and the same contact metrics."""

    scene: Scene
    human_time_s: float
    human_max_mps: float
    human: ContactMetrics


def clip_runs(clip: Clip, profile: Profile, seed: int) -> list[ClipRun]:
    """One run for each driving car of the clip; the speed limit is the car's own maximum."""
    runs = []
    for car in clip.cars():
        if car.mean_speed_mps >= DRIVING_MPS_MIN:
            runs.append(_run(clip, car, profile, seed))
    return runs


def _run(clip: Clip, car: RecordedTrack, profile: Profile, seed: int) -> ClipRun:
    body = profile.body
    path = rear_axle_path(car, body)
    whole = extended(path, _BEFORE_M, _AFTER_M)
    speeds = np.hypot(car.states[:, 3], car.states[:, 4])
    cap_mps = float(speeds.max())
    limits = msgspec.structs.replace(
        profile.limits,
        speed_mps_max=cap_mps,
        lateral_accel_mps2_max=max(profile.limits.lateral_accel_mps2_max, _LATERAL_MPS2),
    )
    human_time_s = float(car.times_s[-1] - car.times_s[0])
    name = f"{clip.name}-car{car.number % 100_000}"
    length_m = float(arc_lengths(path)[-1])
    before_m = math.ceil(_BEFORE_M)
    scene = Scene(
        name=name,
        road_map=path_map(name, whole, width_m=_WIDTH_M, speed_limit_mps=cap_mps),
        profile=msgspec.structs.replace(profile, limits=limits),
        start_s_m=float(before_m),
        start_mps=float(speeds[0]),
        goal_s_m=before_m + length_m,
        limit_s=TIMES_HUMAN_MAX * human_time_s,
        seed=seed,
        actors=ReplayedTraffic(clip, float(car.times_s[0]), frozenset({car.number})),
    )
    return ClipRun(scene, human_time_s, cap_mps, _human(clip, car, body))


def rear_axle_path(car: RecordedTrack, body: Body) -> Array:
    """(n, 2) path of the shuttle's rear axle when its centre follows the car's centre.

    Smoothed to the recording's noise of some centimetres, with a point every half metre.
    """
    back_m = 0.5 * body.length_m - body.rear_overhang_m
    yaw = car.states[:, 2]
    rear = car.states[:, :2] - back_m * np.column_stack((np.cos(yaw), np.sin(yaw)))
    s = arc_lengths(np.ascontiguousarray(rear))
    moved = np.concatenate(([True], np.diff(s) > 1e-4))
    s, rear = s[moved], rear[moved]
    noise_m = 0.04
    splines = [make_splrep(s, rear[:, k], k=3, s=len(s) * noise_m**2) for k in (0, 1)]
    at = np.linspace(0.0, s[-1], max(3, math.ceil(s[-1] / 0.5) + 1))
    path: Array = np.column_stack([spline(at) for spline in splines])
    return path


def _human(clip: Clip, car: RecordedTrack, body: Body) -> ContactMetrics:
    """The contact metrics of the recorded drive, with the shuttle's outline about the car's centre."""
    others = ReplayedTraffic(clip, float(car.times_s[0]), frozenset({car.number}))
    back_m = 0.5 * body.length_m - body.rear_overhang_m
    rows, agents = [], list[Bodies]()
    for t, (x, y, yaw, vx, vy) in zip(car.times_s, car.states, strict=True):
        others.clock_s = float(t)
        rows.append(
            (t, x - back_m * math.cos(yaw), y - back_m * math.sin(yaw), yaw, math.hypot(vx, vy), 0.0, 0.0)
        )
        agents.append(others.bodies())
    return contact_metrics(np.array(rows), agents, body)
