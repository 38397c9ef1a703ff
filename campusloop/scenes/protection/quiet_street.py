"""A street where people walk and stand beside the shuttle's path and never on it."""

import math

import numpy as np

from campusloop.scenes.drive import Scene
from campusloop.scenes.path_map import path_map
from contract.geometry import Array, arc_lengths, pose_at
from simulator.traffic.recordings import RecordedTrack
from simulator.traffic.replayed import ReplayedTraffic
from simulator.traffic.scripted_clips import clip_of, standing, walker
from vehicle_agent.config import Profile
from vehicle_agent.signals import PEDESTRIAN

_EVERY_M = 12.0
_START_M, _BEYOND_M = 14.0, 40.0
# From the vehicle's side to a person's. The vehicle may slow down for the nearest, and has to stop for none.
_BESIDE_M = (0.8, 2.5)


def quiet_street(profile: Profile, length_m: float, seed: int) -> Scene:
    """A winding street of that length with a person every 12 m; half of them walk along it."""
    rng = np.random.default_rng([seed, 77])
    path = _winding(length_m + _START_M + _BEYOND_M, rng)
    s = arc_lengths(path)
    half_m = 0.5 * profile.body.width_m
    tracks: list[RecordedTrack] = []
    for k in range(int(length_m / _EVERY_M)):
        at_m = _START_M + 15.0 + k * _EVERY_M + float(rng.uniform(-3.0, 3.0))
        side = 1.0 if rng.random() < 0.5 else -1.0
        aside_m = side * (half_m + 0.25 + float(rng.uniform(*_BESIDE_M)))
        if rng.random() < 0.5:
            x, y = _beside(path, s, at_m, aside_m)
            tracks.append(standing(k, PEDESTRIAN, x, y))
            continue
        way = 1.0 if rng.random() < 0.5 else -1.0
        places = tuple(
            _beside(path, s, at_m + way * 5.0 * j, aside_m)
            for j in range(12)
            if 0.0 < at_m + way * 5.0 * j < s[-1]
        )
        if len(places) > 1:
            tracks.append(walker(k, PEDESTRIAN, places, float(rng.uniform(1.0, 1.6))))
    speed_mps = profile.limits.speed_mps_max
    return Scene(
        name=f"quiet-street-{seed}",
        road_map=path_map(f"quiet-street-{seed}", path, width_m=4.0, speed_limit_mps=speed_mps),
        profile=profile,
        start_s_m=_START_M,
        start_mps=speed_mps,
        goal_s_m=_START_M + length_m,
        limit_s=4.0 * length_m / speed_mps,
        seed=seed,
        actors=ReplayedTraffic(clip_of("street", tuple(tracks)), 0.0),
    )


def _winding(length_m: float, rng: np.random.Generator) -> Array:
    """(n, 2) a metre apart, bending left and right with a radius of 40 m and more."""
    bends = rng.uniform(-1.0 / 40.0, 1.0 / 40.0, size=math.ceil(length_m / 40.0) + 2)
    at = np.arange(0.0, length_m, 1.0)
    curvature = np.interp(at, 40.0 * np.arange(len(bends)), bends)
    yaw = np.cumsum(curvature)
    return np.column_stack((np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw))))


def _beside(path: Array, s: Array, at_m: float, aside_m: float) -> tuple[float, float]:
    x, y, yaw = pose_at(path, s, at_m)
    return float(x - aside_m * math.sin(yaw)), float(y + aside_m * math.cos(yaw))
