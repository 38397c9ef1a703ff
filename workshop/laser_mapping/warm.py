"""Compiles the kernels of laser mapping into numba's cache."""

import math

import numpy as np

from contract.geometry import Array, Pose2
from workshop.carmen.beams import Beams
from workshop.carmen.laser_logs import LaserLog
from workshop.laser_mapping.mapping import MappingParams, NoProgress, map_log


def warm_kernels() -> None:
    """Map a drive there and back in a square room: it reaches every stage."""
    beams = Beams.of_front_laser(181)
    forth = np.arange(0.0, 10.0, 0.25)
    x_m = np.concatenate([forth, forth[::-1]])
    odometry = np.stack([x_m, np.zeros_like(x_m), np.zeros_like(x_m)], axis=1)
    ranges_m = np.array([_room(x, beams.angles_rad) for x in x_m])
    stamps_s = 0.2 * np.arange(len(x_m), dtype=np.float64)
    log = LaserLog(beams, ranges_m, stamps_s, odometry, Pose2(0.0, 0.0, 0.0), ())
    # The first match is a poor one, so that the search is compiled too.
    ranges_m[1] = 1.0 + 0.5 * np.arange(beams.count) / beams.count
    map_log(log, MappingParams(), NoProgress())


def _room(x_m: float, angles_rad: Array) -> Array:
    """(m,) distances to the walls of a room from -2 to 14 m, 6 m wide, with a step in one wall."""
    out = np.empty(len(angles_rad))
    for number, angle in enumerate(angles_rad):
        ahead = (14.0 - x_m) / max(math.cos(angle), 1e-6)
        side = (3.0 if angle > 0.3 else 2.5) / max(abs(math.sin(angle)), 1e-6)
        out[number] = min(ahead, side)
    return out
