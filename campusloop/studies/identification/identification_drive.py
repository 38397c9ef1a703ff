"""The identification drive in the simulator: a winding road, driven with the program of pedal steps."""

import math

import msgspec
import numpy as np

from campusloop.scenes.drive import Scene
from campusloop.scenes.path_map import path_map
from contract.geometry import Array
from simulator.world import WorldOptions
from vehicle_agent.config import Profile

DRIVE_S = 300.0
_LENGTH_M = 1000.0
_START_S_M = 5.0
_STEP_M = 0.5
_WIDTH_M = 5.0
_SPEED_LIMIT_MPS = 4.2
# Curvature swings between left and right over these lengths, up to the curvature of this multiple of the
# vehicle's own turning circle.
_SWINGS_M = (34.0, 46.0, 28.0, 40.0)
_RADII_SHARE = (1.9, 2.6, 2.1, 3.6)


def winding_path(turn_radius_m: float) -> Array:
    """(n, 2) rear-axle path of curves both ways with changing radii, which never crosses itself."""
    curvatures: list[float] = []
    number = 0
    while len(curvatures) * _STEP_M < _LENGTH_M:
        length_m, share = _SWINGS_M[number % len(_SWINGS_M)], _RADII_SHARE[number % len(_RADII_SHARE)]
        at = np.arange(0.0, length_m, _STEP_M) / length_m
        curvatures += (np.sin(2.0 * math.pi * at) / (share * turn_radius_m)).tolist()
        number += 1
    heading = np.cumsum(curvatures) * _STEP_M
    # Each swing turns left first; about this mean heading the road goes straight on.
    heading -= float(heading.mean())
    steps = _STEP_M * np.column_stack((np.cos(heading), np.sin(heading)))
    path: Array = np.vstack((np.zeros(2), np.cumsum(steps, axis=0)))
    return path


def identification_scene(
    profile: Profile, seed: int, plant_seed: int | None, duration_s: float = DRIVE_S
) -> Scene:
    """The drive of one vehicle. seed: of sensor noise; plant_seed: of its dynamics, None for nominal ones."""
    driving = msgspec.structs.replace(profile.driving, identification_drive=True)
    road_map = path_map(
        "identification",
        winding_path(profile.body.turn_radius_m_min),
        width_m=_WIDTH_M,
        speed_limit_mps=_SPEED_LIMIT_MPS,
    )
    return Scene(
        name="identification",
        road_map=road_map,
        profile=msgspec.structs.replace(profile, driving=driving),
        start_s_m=_START_S_M,
        start_mps=0.0,
        goal_s_m=_LENGTH_M,
        limit_s=duration_s,
        seed=seed,
        options=WorldOptions(traffic=None, plant_seed=plant_seed),
    )
