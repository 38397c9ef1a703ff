"""How people meet a vehicle: decelerations, times to conflict when they slow down, and gaps as it passes.

The same measures are taken of recorded people with the recorded car and of people of the model with the same
car at another time, so that the two can be compared: the model must not make room faster or earlier.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, BoolArray
from simulator.traffic.aware.desired import AHEAD_M_MIN, AHEAD_S, BESIDE_M, free_speed_mps
from simulator.traffic.aware.reproduction import SAMPLE_S, Walk
from simulator.traffic.crowd import RADIUS_M, V_FRONT, V_HALF, V_REAR, V_SPEED, V_X, V_Y, V_YAW
from simulator.traffic.recordings import RecordedTrack

# Speeds and decelerations are differences over this many samples of 0.1 s.
_OVER = 4
# Below this share of the free speed a person has slowed down.
_SLOW_RATIO = 0.7
_WALKING_MPS = 0.5
# Samples around the moment, in which the person slows down.
_REACTION = 15
# A person who walks into the body of a vehicle stops at once, which is a contact and no deceleration.
_TOUCHING_M = 0.05
_DRIVING_MPS = 0.5


@dataclass(frozen=True, slots=True)
class Encounters:
    """One value for each person in a vehicle's way who has it.

    decels_mps2  of people who slowed down by 30 %: the hardest deceleration meanwhile, mean over 0.4 s
    onsets_s     of the same: how far away in time the vehicle was when they had slowed down so far
    gaps_m       the least clearance to the vehicle while it moved
    """

    decels_mps2: Array
    onsets_s: Array
    gaps_m: Array


def recorded_encounters(people: Sequence[RecordedTrack], walk: Walk) -> Encounters:
    """The recorded people's: slow is below 0.7 of the person's free speed."""
    free_mps = np.array([free_speed_mps(person) for person in people])
    speeds = _speeds_mps(walk.recorded, walk.present)
    walkers = np.where(free_mps > _WALKING_MPS, free_mps, np.nan)
    return _encounters(walk.recorded, walk, speeds < _SLOW_RATIO * walkers, speeds)


def aware_encounters(walk: Walk) -> Encounters:
    """Those of people of the model: slow is below 0.7 of their own way's speed."""
    speeds = _speeds_mps(walk.places, walk.present)
    return _encounters(walk.places, walk, walk.paces < _SLOW_RATIO, speeds)


def _speeds_mps(places: Array, present: BoolArray) -> Array:
    """(k, n) mean speeds over 0.4 s; NaN at the ends."""
    half = _OVER // 2
    steps = (places[_OVER:] - places[:-_OVER]) / (_OVER * SAMPLE_S)
    speeds = np.full(present.shape, np.nan)
    both = present[_OVER:] & present[:-_OVER]
    speeds[half:-half] = np.where(both, np.hypot(steps[..., 0], steps[..., 1]), np.nan)
    return speeds


def _encounters(places: Array, walk: Walk, slow: BoolArray, speeds: Array) -> Encounters:
    in_way, ahead_s, clearance_m = _relations(places, walk)
    decels = np.full_like(speeds, np.nan)
    half = _OVER // 2
    decels[half:-half] = (speeds[:-_OVER] - speeds[_OVER:]) / (_OVER * SAMPLE_S)
    moving = np.abs(walk.vehicle[:, V_SPEED]) > _DRIVING_MPS
    of_decel, of_onset, of_gap = [], [], []
    for i in range(places.shape[1]):
        mine = in_way[:, i] & walk.present[:, i]
        if not (mine & moving).any():
            continue
        of_gap.append(float(clearance_m[walk.present[:, i] & moving, i].min()))
        slowed = np.flatnonzero(mine & moving & slow[:, i])
        if not len(slowed) or slow[: slowed[0], i].all():
            continue
        of_onset.append(float(ahead_s[slowed[0], i]))
        near = slice(max(0, slowed[0] - _REACTION), slowed[0] + _REACTION)
        known = decels[near, i][np.isfinite(decels[near, i])]
        if len(known) and clearance_m[near, i].min() > _TOUCHING_M:
            of_decel.append(float(known.max()))
    return Encounters(np.array(of_decel), np.array(of_onset), np.array(of_gap))


def _relations(places: Array, walk: Walk) -> tuple[BoolArray, Array, Array]:
    """(k, n) each: whether the person is in the vehicle's way, the time until it is there, the clearance."""
    row = walk.vehicle[:, None, :]
    dx, dy = places[..., 0] - row[..., V_X], places[..., 1] - row[..., V_Y]
    cos, sin = np.cos(row[..., V_YAW]), np.sin(row[..., V_YAW])
    u, v = cos * dx + sin * dy, cos * dy - sin * dx
    speed = np.abs(row[..., V_SPEED])
    beyond = u - row[..., V_FRONT]
    beside = np.abs(v) - row[..., V_HALF]
    in_way = (
        (beside < BESIDE_M) & (u > -row[..., V_REAR]) & (beyond < np.maximum(AHEAD_M_MIN, AHEAD_S * speed))
    )
    ahead_s = np.maximum(beyond, 0.0) / np.maximum(speed, 0.1)
    du, dv = np.maximum(beyond, -row[..., V_REAR] - u), beside
    apart = np.where((du > 0.0) & (dv > 0.0), np.hypot(du, dv), np.maximum(du, dv)) - RADIUS_M
    return in_way, ahead_s, apart


def joined(parts: Sequence[Encounters]) -> Encounters:
    """All encounters together."""
    return Encounters(
        np.concatenate([part.decels_mps2 for part in parts]),
        np.concatenate([part.onsets_s for part in parts]),
        np.concatenate([part.gaps_m for part in parts]),
    )
