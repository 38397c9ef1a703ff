"""How many shuttles that find road users by themselves this machine carries, and how fast the demo is."""

import os
import time

import numpy as np

from vehicle_agent.config import Profile
from vehicle_agent.stacks.choice import build_perception_worker

# A demo is easier to follow with few.
VEHICLES_MAX = 3
# Lidars turn ten times a second.
_TURNS_PER_S = 10.0
# A shuttle with its simulated lidars, computers and share of the server takes so many times its perception's
# CPU time (1.01 s a second with one, 2.08 s with two; 27 ms a scan).
_OF_PERCEPTION = 3.7
# Processes wait for each other: not every second of every core can be used (two shuttles on two cores: 0.71).
_USABLE = 0.7
# All scans are cast in the simulator's process, each in so many times the CPU time of perception.
_CASTING = 1.25
# Slower than this, more shuttles are no gain.
_PACE_MIN = 0.7
_TURNS = 7
_BEAMS, _COLUMNS = 64, 1800


def cores() -> int:
    """That this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def scan_cpu_s(profile: Profile) -> float:
    """CPU time of the profile's perception for one turn of four lidars, s; measured.

    Kernels must be compiled. Raises DetectorFileError.
    """
    worker = build_perception_worker(profile)
    rows = _turn()
    taken_s = []
    for number in range(1, 1 + _TURNS):
        began_s = time.process_time()
        worker.percepts(rows, 100_000_000 * number)
        taken_s.append(time.process_time() - began_s)
    return float(np.median(taken_s))


def carried(cores: int, scan_s: float) -> int:
    """Shuttles that this many cores carry, at least one; scan_s as `scan_cpu_s` measures it."""
    return max(1, sum(pace(shuttles, cores, scan_s) >= _PACE_MIN for shuttles in range(1, VEHICLES_MAX + 1)))


def pace(shuttles: int, cores: int, scan_s: float) -> float:
    """Of real time, that a demo with so many shuttles keeps; at most 1."""
    scans_s = shuttles * _TURNS_PER_S * scan_s
    return min(1.0, _USABLE * cores / (scans_s * _OF_PERCEPTION), 1.0 / (scans_s * _CASTING))


def _turn() -> np.ndarray:
    """(n, 5) a turn of four lidars among twelve people and six cars, as scan rings have it."""
    below, azimuth = np.meshgrid(
        np.linspace(0.06, 0.5, _BEAMS), np.linspace(-np.pi, np.pi, _COLUMNS, endpoint=False)
    )
    away = 2.3 / np.tan(below.ravel())
    x, y, z = away * np.cos(azimuth.ravel()), away * np.sin(azimuth.ravel()), np.zeros(away.size)
    for number in range(18):
        angle = 2.0 * np.pi * number / 18.0
        is_car = number % 3 == 0
        middle = np.array([np.cos(angle), np.sin(angle)]) * (8.0 + 0.7 * number)
        half, top = (1.6, 1.5) if is_car else (0.25, 1.7)
        # A beam that would meet the ground behind it meets it instead.
        off = (azimuth.ravel() - angle + np.pi) % (2.0 * np.pi) - np.pi
        front = np.hypot(*middle) - half
        height = 2.3 * (1.0 - front / away)
        hit = (np.abs(off) < np.arctan2(half, front)) & (away > front) & (height < top)
        x[hit], y[hit] = front * np.cos(azimuth.ravel()[hit]), front * np.sin(azimuth.ravel()[hit])
        z[hit] = height[hit]
    return np.column_stack((x, y, z, np.full(x.size, 40.0), np.zeros(x.size))).astype(np.float32)
