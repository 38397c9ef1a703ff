"""Decoded packets to points."""

import numpy as np

from vehicle_agent.lidar.models import VELODYNE
from vehicle_agent.lidar.packets import Packets
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud


def cloud_of(packets: Packets, stamps_ns: np.ndarray, chosen: np.ndarray) -> PointCloud:
    """The points of the chosen blocks.

    stamps_ns  (p,) int64 of the packets' beginnings, in the clock of whoever received them
    chosen     (p, blocks) bool

    A return whose distance is 0 or out of the model's range is none. Of two equal returns of one firing the
    second is left out. The stamp is that of the first block; offsets run inside packets by the firing times
    of the model.
    """
    model, returns = packets.model, packets.returns
    range_m = packets.distances * model.distance_m
    valid = (range_m >= model.range_m_min) & (range_m <= model.range_m_max) & chosen[:, :, None]
    for later in range(1, returns):
        same = packets.distances[:, later::returns] == packets.distances[:, later - 1 :: returns]
        valid[:, later::returns] &= ~same
    packet, block, unit = np.nonzero(valid)
    # Velodyne states the azimuth of the first firing of a sequence: the turn until the others is added.
    # Hesai's manuals state one azimuth for all.
    azimuth = np.radians(packets.azimuths_cdeg[packet, block] / 100.0)
    if model.maker == VELODYNE:
        azimuth += _turn_rad_per_ns(packets) * model.firing_ns[unit]
    azimuth += model.azimuths_rad[unit]
    reach = range_m[packet, block, unit]
    level = reach * np.cos(model.elevations_rad[unit])
    points = np.empty((len(reach), 3), dtype=np.float32)
    if model.maker == VELODYNE:
        # ROS drivers' frame: x forward where the azimuth is 0, y left.
        points[:, 0], points[:, 1] = level * np.cos(azimuth), -level * np.sin(azimuth)
    else:
        # Hesai's frame: y where the azimuth is 0.
        points[:, 0], points[:, 1] = level * np.sin(azimuth), level * np.cos(azimuth)
    points[:, 2] = reach * np.sin(model.elevations_rad[unit])
    times_ns = stamps_ns[packet] + firing_ns(packets)[block, unit]
    begun_ns = int(times_ns.min()) if len(times_ns) else int(stamps_ns[0])
    return point_cloud(
        begun_ns, points, packets.intensities[packet, block, unit], model.rings[unit], times_ns - begun_ns
    )


def firing_ns(packets: Packets) -> np.ndarray:
    """(blocks, units) int64: when each beam fires after its packet's beginning."""
    model = packets.model
    sequences = np.arange(packets.azimuths_cdeg.shape[1]) // packets.returns
    offsets = sequences[:, None] * model.sequence_ns + model.firing_ns[None, :]
    rounded: np.ndarray = np.rint(offsets - offsets.min()).astype(np.int64)
    return rounded


def _turn_rad_per_ns(packets: Packets) -> float:
    """How fast the sensor turns, by the middle one of the steps between azimuths."""
    steps = np.diff(packets.azimuths_cdeg[:, :: packets.returns], axis=1) % 36_000
    return float(np.radians(np.median(steps) / 100.0) / packets.model.sequence_ns)
