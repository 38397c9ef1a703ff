"""People who stand beside the way until the shuttle is near, and then walk into it without a look."""

import math
from dataclasses import dataclass

import numpy as np

from campusloop.scenes.contact_metrics import FRONT_DEPTH_M, MOVING_MPS, clearances
from campusloop.scenes.drive import Scene, SceneRun
from campusloop.scenes.path_map import path_map
from campusloop.scenes.protection.braking_oracle import DEAD_S, DECEL_MPS2
from campusloop.scenes.random_crowds import random_curve, random_tracker_noise
from contract.geometry import Array, arc_lengths, pose_at
from simulator.traffic.scripted import ScriptedRole, ScriptedTraffic
from simulator.world import WorldOptions
from vehicle_agent.config import Body, Profile
from vehicle_agent.signals import PEDESTRIAN

PEOPLE = 4
_START_M, _FIRST_M, _APART_M, _AFTER_M = 6.0, 18.0, 14.0, 12.0
_LENGTH_M, _RADIUS_M = 78.0, 25.0
_SPEED_LIMIT_MPS = 4.2
_WIDTH_M = 0.5
# From the vehicle's side to the person's.
_BESIDE_M = (0.3, 1.3)
# Ahead of the bumper when they set off.
_AHEAD_M = (0.5, 5.5)
# Away from straight across: against the shuttle, or along with it.
_ASLANT_RAD = 1.0
_SPEED_MPS, _ACCEL_MPS2 = (0.9, 1.6), (2.0, 5.0)
_WALKED_M = 12.0
_STEP_S = 0.02


@dataclass(frozen=True, slots=True)
class StepIn:
    """One person's step into the way.

    begins_s    when they set off; None: the shuttle did not come so far
    speed_mps   of the vehicle then
    impact_mps  of a front contact with them; None: none
    least_mps   the same of a vehicle that brakes fully from 0.27 s after their first step, on the same way
    """

    number: int
    begins_s: float | None
    speed_mps: float
    impact_mps: float | None
    least_mps: float | None


def stepping_in_scene(profile: Profile, seed: int) -> Scene:
    """A winding way with four people beside it who react to nobody; all of it is drawn from the seed."""
    rng = np.random.default_rng([seed, *b"stepping in"])
    points = random_curve(_LENGTH_M, rng, _RADIUS_M)
    noise = random_tracker_noise(rng)
    s = arc_lengths(points)
    half_m = 0.5 * profile.body.width_m
    roles = tuple(_role(points, s, _FIRST_M + k * _APART_M, half_m, rng) for k in range(PEOPLE))
    name = f"stepping-in-{seed:06d}"
    length_m = float(s[-1])
    return Scene(
        name=name,
        road_map=path_map(
            name, points, width_m=float(rng.uniform(3.5, 8.0)), speed_limit_mps=_SPEED_LIMIT_MPS
        ),
        profile=profile,
        start_s_m=_START_M,
        start_mps=min(2.0, profile.limits.speed_mps_max),
        goal_s_m=length_m - _AFTER_M,
        limit_s=30.0 + 3.0 * length_m,
        seed=seed,
        actors=ScriptedTraffic(roles),
        options=WorldOptions(traffic=None, tracker=noise),
    ).with_plant(seed)


def _role(points: Array, s: Array, at_m: float, half_m: float, rng: np.random.Generator) -> ScriptedRole:
    x, y, yaw = pose_at(points, s, at_m + float(rng.uniform(-2.0, 2.0)))
    side = float(rng.choice((-1.0, 1.0)))
    aside_m = side * (half_m + 0.5 * _WIDTH_M + float(rng.uniform(*_BESIDE_M)))
    x, y = x - aside_m * math.sin(yaw), y + aside_m * math.cos(yaw)
    course = yaw - side * (0.5 * math.pi + float(rng.uniform(-_ASLANT_RAD, _ASLANT_RAD)))
    return ScriptedRole(
        PEDESTRIAN,
        (x, y, course),
        (_WIDTH_M, _WIDTH_M),
        np.array([[x + _WALKED_M * math.cos(course), y + _WALKED_M * math.sin(course)]]),
        float(rng.uniform(*_SPEED_MPS)),
        float(rng.uniform(*_ACCEL_MPS2)),
        distance_m=math.hypot(float(rng.uniform(*_AHEAD_M)), aside_m),
        stays=False,
    )


def steps_in(run: SceneRun, body: Body) -> list[StepIn]:
    """What became of each of the people, in the order of the way."""
    hits = {number: speed_mps for _, number, speed_mps in reversed(run.metrics.front_contacts)}
    rows = run.trace.array()
    found = []
    for number in range(1, PEOPLE + 1):
        begins = _first_step(run, number)
        if begins is None:
            found.append(StepIn(number, None, 0.0, None, None))
            continue
        impact_mps = hits.get(number)
        least_mps = None if impact_mps is None else _least_impact_mps(run, number, begins, body)
        found.append(StepIn(number, float(rows[begins, 0]), float(rows[begins, 4]), impact_mps, least_mps))
    return found


def _first_step(run: SceneRun, number: int) -> int | None:
    for i, bodies in enumerate(run.trace.agents):
        k = np.flatnonzero(bodies.numbers == number)
        if len(k) and np.hypot(*bodies.velocities_map_mps[k[0]]) > 0.0:
            return i
    return None


def _least_impact_mps(run: SceneRun, number: int, begins: int, body: Body) -> float | None:
    """Full braking from DEAD_S after the first step, along the way that was driven."""
    rows = run.trace.array()
    driven_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(rows[:, 1:3], axis=0).T))))
    at_m, speed_mps = float(driven_m[begins]), float(rows[begins, 4])
    outline = (body.rear_overhang_m, body.front_overhang_m, 0.5 * body.width_m)
    yaws = np.unwrap(rows[:, 3])
    for i in range(begins, len(rows)):
        x_m, y_m, yaw_rad = (np.interp(at_m, driven_m, column) for column in (rows[:, 1], rows[:, 2], yaws))
        bodies = run.trace.agents[i]
        gaps, ahead = clearances(x_m, y_m, yaw_rad, *outline, bodies.poses_map, bodies.sizes_m, bodies.people)
        touches = (bodies.numbers == number) & (gaps < 0.0) & (ahead > body.front_overhang_m - FRONT_DEPTH_M)
        if speed_mps <= MOVING_MPS:
            return None
        if touches.any():
            return speed_mps
        if i - begins >= round(DEAD_S / _STEP_S):
            speed_mps -= DECEL_MPS2 * _STEP_S
        at_m += speed_mps * _STEP_S
    return None
