"""Tracks with defaults."""

import math

import numpy as np

from vehicle_agent.signals import PEDESTRIAN, VEHICLE, Tracks

SIZES_M = {PEDESTRIAN: (0.5, 0.5), VEHICLE: (4.5, 1.8)}


def some_tracks(*rows: tuple[int, float, float, float, float], stamp_ns: int = 1) -> Tracks:
    """rows: kind, x, y, vx, vy; their ids count from 0."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    kinds = table[:, 0].astype(np.int64)
    headings = [math.atan2(vy, vx) for vx, vy in table[:, 3:]]
    return Tracks(
        stamp_ns,
        np.arange(len(table), dtype=np.int64),
        kinds,
        np.column_stack((table[:, 1:3], headings)).reshape(-1, 3),
        table[:, 3:].copy(),
        np.array([SIZES_M.get(int(kind), (1.8, 0.6)) for kind in kinds]).reshape(-1, 2),
    )
