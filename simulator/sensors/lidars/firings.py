"""The rays of one turn, each from the pose that the sensor has when it fires."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from vehicle_agent.lidar.models import VELODYNE, LidarModel

Array32 = NDArray[np.float32]
Times = NDArray[np.int64]


def turn_of(model: LidarModel, rate_hz: float) -> tuple[Array32, Times, NDArray[np.uint16]]:
    """(directions (n, 3), offsets_ns (n,), rings (n,)) of one turn in the order of firing.

    Directions are in the frame of the sensor's maker, as `vehicle_agent.lidar.clouds` decodes them: a
    Velodyne turns on between the firings of a sequence, a Hesai's manual states one azimuth for all.
    """
    columns = round(1e9 / rate_hz / model.sequence_ns)
    starts_ns = model.sequence_ns * np.arange(columns)
    order = np.argsort(model.firing_ns, kind="stable")
    firing_ns = model.firing_ns[order] - model.firing_ns.min()
    azimuth = (2.0 * math.pi / columns) * np.arange(columns)[:, None] + model.azimuths_rad[order]
    if model.maker == VELODYNE:
        azimuth = azimuth + (2.0 * math.pi / columns / model.sequence_ns) * firing_ns
    level = np.broadcast_to(np.cos(model.elevations_rad[order]), azimuth.shape)
    up = np.broadcast_to(np.sin(model.elevations_rad[order]), azimuth.shape)
    cos, sin = level * np.cos(azimuth), level * np.sin(azimuth)
    frame = (cos, -sin, up) if model.maker == VELODYNE else (sin, cos, up)
    directions = np.stack(frame, axis=2).reshape(-1, 3).astype(np.float32)
    offsets_ns = np.rint(starts_ns[:, None] + firing_ns).astype(np.int64).ravel()
    return directions, offsets_ns, np.tile(model.rings[order], columns)


@njit(cache=True)
def fire(
    poses: Array,
    step_ns: float,
    directions: Array32,
    offsets_ns: Times,
    own_ranges: Array32,
    origins_out: Array32,
    directions_out: Array32,
    rays_out: NDArray[np.int64],
) -> int:
    """Write the rays that the own body does not stop, and return their number.

    poses       (k, 4, 4) T_map_sensor every step_ns from the begin of the turn; between them all is linear
    own_ranges  (n,) 0.0 where the vehicle itself is not in the way
    rays_out    which firing each ray is
    """
    count = 0
    last = poses.shape[0] - 2
    for k in range(directions.shape[0]):
        if own_ranges[k] > 0.0:
            continue
        at = offsets_ns[k] / step_ns
        i = min(int(at), last)
        f = at - i
        a, b = poses[i], poses[i + 1]
        dx, dy, dz = directions[k, 0], directions[k, 1], directions[k, 2]
        norm = 0.0
        for r in range(3):
            value = 0.0
            value += (a[r, 0] + f * (b[r, 0] - a[r, 0])) * dx
            value += (a[r, 1] + f * (b[r, 1] - a[r, 1])) * dy
            value += (a[r, 2] + f * (b[r, 2] - a[r, 2])) * dz
            directions_out[count, r] = value
            norm += value * value
            origins_out[count, r] = a[r, 3] + f * (b[r, 3] - a[r, 3])
        # A chord between two rotations is a little shorter than 1.
        scale = 1.0 / math.sqrt(norm)
        for r in range(3):
            directions_out[count, r] *= scale
        rays_out[count] = k
        count += 1
    return count
