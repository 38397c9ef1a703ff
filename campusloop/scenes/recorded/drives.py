"""The forward drives of a recorded car, and the path that a shuttle drives in its place.

A car that stands trembles in a recording: its positions wander by some centimetres. So a drive is measured by
its advance along the car's heading, and its path has a point only where the car has advanced.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_splrep

from contract.geometry import Array, arc_lengths
from simulator.traffic.recordings import RecordedTrack
from vehicle_agent.config import Body

# Cars with a lower mean speed are parked or waiting; they are obstacles.
DRIVING_MPS_MIN = 0.5
# A shorter way is a manoeuvre, and too short to compare times on.
WAY_M_MIN = 3.0
# Backing by less is trembling.
_BACKING_M = 0.5
_ADVANCE_M = 0.25
_ARRIVED_M = 0.05
# A recording's positions have a noise of some centimetres; they are smoothed over this time.
_SMOOTH_S = 0.5
_NOISE_M = 0.04
_SPACING_M = 0.5


@dataclass(frozen=True, slots=True)
class RecordedDrive:
    """One drive forwards, stands included.

    car       the car's track from the beginning of the drive to its arrival, heading in the drive's direction
    places    (n, 3) x, y, yaw of the car's middle, one for each advance of a quarter of a metre
    """

    car: RecordedTrack
    places: Array

    @property
    def time_s(self) -> float:
        return float(self.car.times_s[-1] - self.car.times_s[0])

    @property
    def length_m(self) -> float:
        return float(arc_lengths(np.ascontiguousarray(self.places[:, :2]))[-1])

    @property
    def speed_mps_max(self) -> float:
        """The car's highest speed."""
        return float(np.hypot(self.car.states[:, 3], self.car.states[:, 4]).max())


def recorded_drives(car: RecordedTrack) -> list[RecordedDrive]:
    """The drives of a car, in order of time: none for a parked car, several if it backs in between.

    A car that only backs is one drive in the direction of its motion. What it backs in between is no drive.
    """
    if len(car.times_s) < 3:
        return []
    places = _smoothed(car)
    headings = np.column_stack((np.cos(car.states[:, 2]), np.sin(car.states[:, 2])))
    steps = (np.diff(places, axis=0) * headings[:-1]).sum(axis=1)
    if steps.sum() < 0.0:
        steps, car = -steps, _turned(car)
    advance_m = np.concatenate(([0.0], np.cumsum(steps)))
    drives = []
    for begin, end in _forward_parts(advance_m):
        drive = _drive(car, places, advance_m, begin, end)
        if drive.length_m >= WAY_M_MIN and drive.length_m >= DRIVING_MPS_MIN * drive.time_s:
            drives.append(drive)
    return drives


def _smoothed(car: RecordedTrack) -> Array:
    """(n, 2) means of the positions within half of _SMOOTH_S, fewer towards both ends."""
    times, n = car.times_s, len(car.times_s)
    sums = np.vstack((np.zeros((1, 2)), np.cumsum(car.states[:, :2], axis=0)))
    reach = np.minimum(0.5 * _SMOOTH_S, np.minimum(times - times[0], times[-1] - times)) + 1e-9
    low = np.searchsorted(times, times - reach)
    high = np.minimum(np.searchsorted(times, times + reach), n)
    means: Array = (sums[high] - sums[low]) / (high - low)[:, None]
    return means


def _turned(car: RecordedTrack) -> RecordedTrack:
    states = car.states.copy()
    states[:, 2] += math.pi
    return replace(car, states=states)


def _forward_parts(advance_m: Array) -> list[tuple[int, int]]:
    """(first, last) of each part in which the car never backs by _BACKING_M."""
    parts = []
    begin = highest = lowest = 0
    backing = False
    for k in range(1, len(advance_m)):
        if backing:
            lowest = k if advance_m[k] <= advance_m[lowest] else lowest
            if advance_m[k] > advance_m[lowest] + _BACKING_M:
                backing, begin, highest = False, lowest, k
        else:
            highest = k if advance_m[k] >= advance_m[highest] else highest
            if advance_m[k] < advance_m[highest] - _BACKING_M:
                parts.append((begin, highest))
                backing, lowest = True, k
    if not backing:
        parts.append((begin, len(advance_m) - 1))
    return parts


def _drive(car: RecordedTrack, places: Array, advance_m: Array, begin: int, end: int) -> RecordedDrive:
    """The drive from `begin` until the car arrives at the farthest place before `end`."""
    farthest_m = float(advance_m[begin : end + 1].max())
    arrived = begin + int(np.argmax(advance_m[begin : end + 1] >= farthest_m - _ARRIVED_M))
    kept = [begin]
    for k in range(begin + 1, arrived + 1):
        if advance_m[k] >= advance_m[kept[-1]] + _ADVANCE_M:
            kept.append(k)
    if kept[-1] != arrived and advance_m[arrived] > advance_m[kept[-1]] + _ARRIVED_M:
        kept.append(arrived)
    part = replace(
        car, times_s=car.times_s[begin : arrived + 1], states=car.states[begin : arrived + 1].copy()
    )
    return RecordedDrive(part, np.column_stack((places[kept], car.states[kept, 2])))


def rear_axle_path(drive: RecordedDrive, body: Body) -> Array:
    """(n, 2) path of the shuttle's rear axle when its centre follows the car's centre.

    Smoothed to the recording's noise of some centimetres, with a point every half metre.
    """
    back_m = 0.5 * body.length_m - body.rear_overhang_m
    yaw = drive.places[:, 2]
    rear = drive.places[:, :2] - back_m * np.column_stack((np.cos(yaw), np.sin(yaw)))
    s = arc_lengths(np.ascontiguousarray(rear))
    moved = np.concatenate(([True], np.diff(s) > 1e-4))
    s, rear = s[moved], rear[moved]
    degree = min(3, len(s) - 1)
    splines = [make_splrep(s, rear[:, k], k=degree, s=len(s) * _NOISE_M**2) for k in (0, 1)]
    at = np.linspace(0.0, s[-1], max(3, math.ceil(s[-1] / _SPACING_M) + 1))
    path: Array = np.column_stack([spline(at) for spline in splines])
    return path
