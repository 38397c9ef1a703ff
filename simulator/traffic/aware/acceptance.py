"""What each person accepted of the recorded cars: how near, and how late before a predicted conflict."""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from contract.geometry import Array
from simulator.traffic.actors import Ints
from simulator.traffic.aware.conflict import (
    PREDICTION_STEP_S,
    PREDICTIONS,
    clearance_m,
    first_conflict,
    predicted_poses,
)
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.reaction import L_MARGIN, L_NOTICE
from simulator.traffic.aware.ways import WAY_STEP_S, OwnWays, place_at
from simulator.traffic.crowd import V_FRONT, V_HALF, V_REAR, V_SPEED, V_X, V_Y, V_YAW, VEHICLE_COLUMNS
from simulator.traffic.recordings import RecordedTrack

_LOOK_S = 0.1
# People see over this time how a vehicle turns and brakes.
_MOTION_S = 0.4
_DRIVING_MPS = 0.5
_MARGIN_M_MIN = 0.02
_NEAR_M = 40.0


def car_rows(car: RecordedTrack, at_s: Array) -> tuple[Array, Array]:
    """((k, 7), (k, 2)) rows of `traffic.crowd` with the car's middle, NaN while it is away; its motions."""
    rows = _rows(car, at_s)
    before, after = (_rows(car, at_s + shift_s) for shift_s in (-_MOTION_S, 0.0))
    motions = np.column_stack(
        ((after - before)[:, V_YAW] / _MOTION_S, (after - before)[:, V_SPEED] / _MOTION_S)
    )
    rows[(at_s < car.times_s[0] - 1e-6) | (at_s > car.times_s[-1] + 1e-6)] = np.nan
    return rows, motions


def _rows(car: RecordedTrack, at_s: Array) -> Array:
    x, y, yaw, vx, vy = (np.interp(at_s, car.times_s, car.states[:, c]) for c in range(5))
    rows = np.zeros((len(at_s), VEHICLE_COLUMNS))
    rows[:, V_X], rows[:, V_Y], rows[:, V_YAW] = x, y, yaw
    rows[:, V_REAR] = rows[:, V_FRONT] = 0.5 * car.size_m[0]
    rows[:, V_HALF] = 0.5 * car.size_m[1]
    rows[:, V_SPEED] = vx * np.cos(yaw) + vy * np.sin(yaw)
    return rows


def is_driving(car: RecordedTrack) -> bool:
    """The car moves at some time; parked cars are obstacles that are heeded already."""
    return bool(np.hypot(car.states[:, 3], car.states[:, 4]).max() > _DRIVING_MPS)


def accepted_limits(ways: OwnWays, cars: Sequence[RecordedTrack], params: ReactionParams) -> Array:
    """(n, 2) margin_m and notice_s of each person: the fitted ones, or less where less was accepted.

    A person who came nearer to a driving car keeps that margin. One who went on although a conflict was
    nearer in time reacts to the shuttle as late as that.
    """
    limits = params.limits(len(ways.count))
    way = (ways.places, ways.first, ways.count, ways.begins_s, ways.ends_mps)
    looks = []
    for car in cars:
        if is_driving(car):
            at_s = np.arange(car.times_s[0], car.times_s[-1], _LOOK_S)
            looks.append((at_s, *car_rows(car, at_s)))
    for at_s, rows, _ in looks:
        _lower_margins(*way, limits, at_s, rows)
    for at_s, rows, motions in looks:
        _lower_notices(*way, limits, at_s, rows, motions)
    return limits


@njit(cache=True)
def _lower_margins(
    places: Array,
    first: Ints,
    count: Ints,
    begins_s: Array,
    ends_mps: Array,
    limits: Array,
    at_s: Array,
    rows: Array,
) -> None:
    for i in range(len(first)):
        ends_s = begins_s[i] + WAY_STEP_S * (count[i] - 1)
        for k in range(len(at_s)):
            if at_s[k] < begins_s[i] or at_s[k] > ends_s or math.isnan(rows[k, 0]):
                continue
            x, y = place_at(places, first[i], count[i], begins_s[i], ends_mps[i], at_s[k])
            there_m = clearance_m(x, y, rows[k, :3], rows[k])
            if there_m < limits[i, L_MARGIN] + _MARGIN_M_MIN:
                limits[i, L_MARGIN] = max(_MARGIN_M_MIN, there_m - _MARGIN_M_MIN)


@njit(cache=True)
def _lower_notices(
    places: Array,
    first: Ints,
    count: Ints,
    begins_s: Array,
    ends_mps: Array,
    limits: Array,
    at_s: Array,
    rows: Array,
    motions: Array,
) -> None:
    track = np.empty((PREDICTIONS, 2))
    for k in range(len(at_s)):
        if math.isnan(rows[k, 0]):
            continue
        poses = predicted_poses(rows[k : k + 1], motions[k : k + 1])
        for i in range(len(first)):
            ends_s = begins_s[i] + WAY_STEP_S * (count[i] - 1)
            if at_s[k] < begins_s[i] or at_s[k] > ends_s:
                continue
            x, y = place_at(places, first[i], count[i], begins_s[i], ends_mps[i], at_s[k])
            if math.hypot(x - rows[k, 0], y - rows[k, 1]) > _NEAR_M:
                continue
            for h in range(PREDICTIONS):
                own_s = at_s[k] + h * PREDICTION_STEP_S
                track[h] = place_at(places, first[i], count[i], begins_s[i], ends_mps[i], own_s)
            step, _ = first_conflict(track, rows[k], poses[0], limits[i, L_MARGIN])
            if step < PREDICTIONS:
                accepted_s = (step - 0.5) * PREDICTION_STEP_S
                limits[i, L_NOTICE] = max(0.0, min(limits[i, L_NOTICE], accepted_s))
