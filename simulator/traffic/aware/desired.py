"""Where a person would have gone without the car: the recorded way with the car's influence taken out."""

import math

import numpy as np

from contract.geometry import Array
from simulator.traffic.recordings import RecordedTrack

# A person who is ahead of a car's rear by less than it drives in this time, and no farther beside its course,
# may be influenced by it.
AHEAD_S, AHEAD_M_MIN, BESIDE_M = 4.0, 3.0, 2.5
# A longer stay in the neighbourhood is no passing.
PASSING_S_MAX = 10.0
_STEP_S = 0.05
FREE_PERCENTILE = 70.0
_WALKING_MPS = 0.5


def near_s(person: RecordedTrack, cars: list[RecordedTrack]) -> list[tuple[float, float]]:
    """(from, to) of each time that the person was in the way of one of the cars."""
    times = person.times_s
    near = np.zeros(len(times), dtype=bool)
    for car in cars:
        x, y, yaw, vx, vy = (np.interp(times, car.times_s, car.states[:, k]) for k in range(5))
        dx, dy = person.states[:, 0] - x, person.states[:, 1] - y
        ahead_m = np.cos(yaw) * dx + np.sin(yaw) * dy
        beside_m = np.abs(np.cos(yaw) * dy - np.sin(yaw) * dx) - 0.5 * car.size_m[1]
        reach_m = 0.5 * car.size_m[0] + np.maximum(AHEAD_M_MIN, AHEAD_S * np.hypot(vx, vy))
        there = (times >= car.times_s[0]) & (times <= car.times_s[-1])
        near |= there & (beside_m < BESIDE_M) & (ahead_m > -0.5 * car.size_m[0]) & (ahead_m < reach_m)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], near.astype(np.int8), [0]))))
    return [(float(times[a]), float(times[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def free_speed_mps(person: RecordedTrack, percentile: float = FREE_PERCENTILE) -> float:
    """The speed at which the person walks where nothing holds them up: the fast side of their own speeds."""
    return float(np.percentile(np.hypot(person.states[:, 3], person.states[:, 4]), percentile))


def desired_way(
    person: RecordedTrack, near: list[tuple[float, float]], percentile: float = FREE_PERCENTILE
) -> tuple[Array, Array]:
    """(times_s (n,), states (n, 5)): in each neighbourhood the person goes on as on entering it, to where
    they left it, on a smooth curve at free speed. Who stands by themselves is left as recorded."""
    speed = free_speed_mps(person, percentile)
    times, states = person.times_s.copy(), person.states.copy()
    if speed < _WALKING_MPS:
        return times, states
    for begin_s, end_s in reversed(near):
        if not 3 * _STEP_S < end_s - begin_s <= PASSING_S_MAX:
            continue
        a, b = int(np.searchsorted(person.times_s, begin_s)), int(np.searchsorted(person.times_s, end_s))
        curve = _curve(person.states[a], person.states[b])
        length = float(np.hypot(*np.diff(curve, axis=0).T).sum())
        if length < 0.5:
            continue
        new_s = max(2, math.ceil(length / speed / _STEP_S)) * _STEP_S
        at = np.arange(0.0, new_s + 1e-9, _STEP_S)
        s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))))
        along = np.minimum(at * speed, s[-1])
        places = np.column_stack([np.interp(along, s, curve[:, k]) for k in (0, 1)])
        velocities = np.gradient(places, _STEP_S, axis=0)
        yaws = np.unwrap(np.arctan2(velocities[:, 1], velocities[:, 0]))
        middle = np.column_stack((places, yaws, velocities))
        shift_s = begin_s + at[-1] - end_s
        times = np.concatenate((times[:a], begin_s + at, times[b + 1 :] + shift_s))
        states = np.vstack((states[:a], middle, states[b + 1 :]))
    return times, states


def _curve(start: Array, end: Array) -> Array:
    """(25, 2) cubic between two states with their directions; straight where they stand."""
    gap = float(np.hypot(*(end[:2] - start[:2])))
    chord = (end[:2] - start[:2]) / max(gap, 1e-9)
    tangents = []
    for state in (start, end):
        speed = float(np.hypot(state[3], state[4]))
        tangents.append(gap * (state[3:5] / speed if speed > 0.3 else chord))
    t = np.linspace(0.0, 1.0, 25)[:, None]
    return (
        (2 * t**3 - 3 * t**2 + 1) * start[:2]
        + (t**3 - 2 * t**2 + t) * tangents[0]
        + (3 * t**2 - 2 * t**3) * end[:2]
        + (t**3 - t**2) * tangents[1]
    )
