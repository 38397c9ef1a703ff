"""How near people pass before a vehicle that stands: in recordings, and in the reactive crowd."""

from collections.abc import Sequence

import numpy as np

from contract.geometry import Array
from simulator.traffic.corridor import SAMPLES, SPACING_M
from simulator.traffic.crowd import V_FRONT, V_HALF, V_X, V_Y, V_YAW
from simulator.traffic.recordings import Clip
from simulator.traffic.social_crowd import CrowdParams, SocialCrowd
from simulator.traffic.social_force import VX, VY, X, Y

# A vehicle that is slower stands; a person who is faster across walks; passes farther ahead are not counted.
_STANDS_MPS, _WALKS_MPS, _FAR_M = 0.15, 0.4, 8.0
# People this much beside the body count as before it.
_BESIDE_M = 0.1
_EVERY_STEPS, _DT_S = 5, 0.02
# As rows of `simulator.traffic.crowd`: at rest half way along a straight path with a point every metre.
_SHUTTLE = (40.0, 0.0, 0.0, 0.85, 3.5, 0.815, 0.0)
_PATH_POINTS, _STAND_S = 81, 60.0
_CROWD = CrowdParams(people_per_100m2=6.0, attentive_ratio=1.0)


def recorded_passes_m(clips: Sequence[Clip]) -> Array:
    """(n,) the least distance of each person's middle from the bumper of each standing car."""
    found: list[float] = []
    for clip in clips:
        people = [track for track in clip.tracks if not track.is_driven]
        for car in clip.cars():
            stands = np.hypot(car.states[:, 3], car.states[:, 4]) < _STANDS_MPS
            body = (0.5 * car.size_m[0], 0.5 * car.size_m[1])
            for person in people:
                there = stands & (person.times_s[0] <= car.times_s) & (car.times_s <= person.times_s[-1])
                if not there.any():
                    continue
                times_s = car.times_s[there]
                at = np.column_stack([np.interp(times_s, person.times_s, c) for c in person.states.T])
                ahead_m, is_passing = _before(car.states[there, :3], body, at[:, :2], at[:, 3:5])
                if is_passing.any():
                    found.append(float(ahead_m[is_passing].min()))
    return np.array(found)


def crowd_passes_m(seeds: Sequence[int]) -> Array:
    """(n,) the same of attentive people of a reactive crowd (6 on 100 m2), about a shuttle that stands for a
    minute."""
    found: list[float] = []
    path = np.column_stack((np.arange(float(_PATH_POINTS)), np.zeros(_PATH_POINTS)))
    vehicles = np.array([_SHUTTLE])
    body = (_SHUTTLE[V_FRONT], _SHUTTLE[V_HALF])
    ahead = np.zeros((1, SAMPLES, 2))
    ahead[0, :, 0] = vehicles[0, V_X] + SPACING_M * np.arange(SAMPLES)
    for seed in seeds:
        crowd = SocialCrowd(_CROWD, path, seed)
        nearest: dict[int, float] = {}
        for step in range(round(_STAND_S / _DT_S)):
            crowd.step(vehicles, np.zeros(1), ahead, _DT_S)
            if step % _EVERY_STEPS:
                continue
            people = crowd.people
            poses = np.broadcast_to(vehicles[0, [V_X, V_Y, V_YAW]], (len(people), 3))
            ahead_m, is_passing = _before(poses, body, people[:, [X, Y]], people[:, [VX, VY]])
            for i in np.flatnonzero(is_passing):
                nearest[int(i)] = min(nearest.get(int(i), np.inf), float(ahead_m[i]))
        found += nearest.values()
    return np.array(found)


def _before(
    poses: Array, body: tuple[float, float], places: Array, velocities: Array
) -> tuple[Array, np.ndarray]:
    """((n,) distance ahead of the bumper, (n,) walks across before it) of people seen from poses (n, 3).

    body: the bumper's distance from the pose, and half the width
    """
    front_m, half_m = body
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx, dy = (places - poses[:, :2]).T
    ahead_m = cos * dx + sin * dy - front_m
    aside_m = np.abs(cos * dy - sin * dx)
    across_mps = np.abs(cos * velocities[:, 1] - sin * velocities[:, 0])
    is_passing = (
        (ahead_m > 0.0) & (ahead_m < _FAR_M) & (aside_m < half_m + _BESIDE_M) & (across_mps > _WALKS_MPS)
    )
    return ahead_m, is_passing
