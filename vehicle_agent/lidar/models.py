"""The lidars that are known: their beams, as the makers' manuals give them, and their firing times.

A sensor's own angle file (`angle_file.py`) replaces the nominal beams of a Hesai.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from contract.geometry import Array

VELODYNE, HESAI = "velodyne", "hesai"


@dataclass(frozen=True, slots=True, eq=False)
class LidarModel:
    """Beams in the order of a packet's channels.

    elevations_rad, azimuths_rad  (channels,) above the horizon; added to the block's azimuth
    firing_ns                     (channels,) after the beginning of the firing sequence
    sequence_ns                   from one firing sequence, that is one azimuth, to the next
    distance_m                    metres of one unit of distance
    """

    name: str
    maker: str
    elevations_rad: Array
    azimuths_rad: Array
    firing_ns: Array
    sequence_ns: float
    distance_m: float
    range_m_min: float
    range_m_max: float

    @property
    def channels(self) -> int:
        return len(self.elevations_rad)

    @property
    def rings(self) -> np.ndarray:
        """(channels,) the place of each beam from the lowest upwards."""
        order = np.empty(self.channels, dtype=np.uint16)
        order[np.argsort(self.elevations_rad, kind="stable")] = np.arange(self.channels, dtype=np.uint16)
        return order

    def with_angles(self, elevations_rad: Array, azimuths_rad: Array) -> "LidarModel":
        """This model with the measured angles of one sensor, (channels,) each."""
        return replace(self, elevations_rad=elevations_rad, azimuths_rad=azimuths_rad)


def _interleaved(lowest_deg: float, step_deg: float, channels: int) -> Array:
    """Velodyne's order: the lower half and the upper half of the beams alternate."""
    beams = lowest_deg + step_deg * np.arange(channels)
    half = channels // 2
    ordered: Array = np.column_stack((beams[:half], beams[half:])).ravel()
    return ordered


# Velodyne 63-9243 (VLP-16), 63-9318 (Puck Hi-Res), 63-9113 (HDL-32E), 63-9325 (VLP-32C): one sequence of all
# beams takes 55.296 us (HDL-32E: 46.08 us), one firing 2.304 us (HDL-32E: 1.152 us; VLP-32C: two at a time).
# The VLP-16's beams start up to 11 mm above or below its centre; that is left out, as ROS drivers do.
_VLP16_US = 2.304 * np.arange(16)
_VLP32C_DEG = (
    -25.0, -1.0, -1.667, -15.639, -11.31, 0.0, -0.667, -8.843, -7.254, 0.333, -0.333, -6.148, -5.333, 1.333,
    0.667, -4.0, -4.667, 1.667, 1.0, -3.667, -3.333, 3.333, 2.333, -2.667, -3.0, 7.0, 4.667, -2.333, -2.0,
    15.0, 10.333, -1.333,
)  # fmt: skip
_VLP32C_AZIMUTH_DEG = (
    1.4, -4.2, 1.4, -1.4, 1.4, -1.4, 4.2, -1.4, 1.4, -4.2, 1.4, -1.4, 4.2, -1.4, 4.2, -1.4,
    1.4, -4.2, 1.4, -4.2, 4.2, -1.4, 1.4, -1.4, 1.4, -1.4, 1.4, -4.2, 4.2, -1.4, 1.4, -1.4,
)  # fmt: skip

# Hesai's manuals of PandarXT-16 and XT-32, Pandar40P, Pandar64 and PandarQT: nominal angles, top beam first
# (PandarQT: lowest first), and firing times inside a block.
_PANDAR40P_DEG = (
    14.794, 10.944, 7.971, 4.969, 2.952, 1.94, 1.6, 1.263, 0.925, 0.587, 0.249, -0.088, -0.425, -0.763,
    -1.101, -1.439, -1.776, -2.116, -2.453, -2.788, -3.128, -3.463, -3.8, -4.138, -4.473, -4.808, -5.145,
    -5.479, -5.814, -6.149, -7.151, -8.147, -9.148, -10.133, -11.12, -12.094, -13.062, -14.018, -18.977,
    -24.985,
)  # fmt: skip
_PANDAR40P_AZIMUTH_DEG = (-1.042,) * 6 + (3.125, -5.208, -1.042) * 8 + (-1.042,) * 10
_PANDAR40P_US = (
    -42.22, -28.47, -16.04, -3.62, -45.49, -31.74, -47.46, -54.67, -20.62, -33.71, -40.91, -8.19, -20.62,
    -27.16, -50.73, -8.19, -14.74, -36.98, -45.49, -52.7, -23.89, -31.74, -38.95, -11.47, -18.65, -25.19,
    -48.76, -6.23, -12.77, -35.01, -21.92, -9.5, -43.52, -29.77, -17.35, -4.92, -42.22, -28.47, -16.04, -3.62,
)  # fmt: skip
_PANDAR64_DEG = (
    14.9, 11.05, 8.077, 5.075, 3.058, 2.046, 1.878, 1.706, 1.54, 1.369, 1.202, 1.031, 0.864, 0.693, 0.526,
    0.355, 0.187, 0.018, -0.151, -0.319, -0.49, -0.657, -0.827, -0.995, -1.166, -1.333, -1.504, -1.67, -1.842,
    -2.01, -2.18, -2.347, -2.518, -2.682, -2.855, -3.022, -3.192, -3.357, -3.53, -3.694, -3.866, -4.032,
    -4.203, -4.367, -4.54, -4.702, -4.874, -5.039, -5.211, -5.373, -5.547, -5.708, -5.88, -6.043, -7.045,
    -8.041, -9.042, -10.027, -11.014, -11.988, -12.956, -13.912, -18.871, -24.879,
)  # fmt: skip
_PANDAR64_AZIMUTH_DEG = (-1.042,) * 6 + (1.042, 3.125, 5.208, -5.208, -3.125, -1.042) * 8 + (-1.042,) * 10
_PANDAR64_US = (
    -23.18, -21.876, -20.572, -19.268, -17.964, -16.66, -11.444, -46.796, -7.532, -36.956, -50.732, -54.668,
    -40.892, -44.828, -31.052, -34.988, -48.764, -52.7, -38.924, -42.86, -29.084, -33.02, -46.796, -25.148,
    -36.956, -50.732, -27.116, -40.892, -44.828, -31.052, -34.988, -48.764, -25.148, -38.924, -42.86, -29.084,
    -33.02, -52.7, -6.228, -54.668, -15.356, -27.116, -10.14, -23.18, -4.924, -21.876, -14.052, -17.964,
    -8.836, -19.268, -3.62, -20.572, -12.748, -16.66, -7.532, -11.444, -6.228, -15.356, -10.14, -4.924, -3.62,
    -14.052, -8.836, -12.748,
)  # fmt: skip


def _model(
    name: str,
    maker: str,
    elevations_deg: ArrayLike,
    firing_us: ArrayLike,
    sequence_us: float,
    range_m: tuple[float, float],
    azimuths_deg: tuple[float, ...] | None = None,
    distance_m: float = 0.004,
) -> LidarModel:
    elevations = np.radians(np.asarray(elevations_deg, dtype=np.float64))
    azimuths = np.zeros(len(elevations)) if azimuths_deg is None else np.radians(np.asarray(azimuths_deg))
    firing_ns = 1e3 * np.asarray(firing_us, dtype=np.float64)
    assert len(elevations) == len(azimuths) == len(firing_ns)
    return LidarModel(
        name, maker, elevations, azimuths, firing_ns, 1e3 * sequence_us, distance_m, range_m[0], range_m[1]
    )


VLP16 = _model(
    "VLP-16", VELODYNE, _interleaved(-15.0, 2.0, 16), _VLP16_US, 55.296, (0.4, 130.0), distance_m=0.002
)
PUCK_HI_RES = _model(
    "Puck Hi-Res", VELODYNE, _interleaved(-10.0, 4.0 / 3.0, 16), _VLP16_US, 55.296, (0.4, 130.0),
    distance_m=0.002,
)  # fmt: skip
HDL32E = _model(
    "HDL-32E", VELODYNE, _interleaved(-92.0 / 3.0, 4.0 / 3.0, 32), 1.152 * np.arange(32), 46.08, (0.4, 130.0),
    distance_m=0.002,
)  # fmt: skip
VLP32C = _model(
    "VLP-32C", VELODYNE, _VLP32C_DEG, 2.304 * (np.arange(32) // 2), 55.296, (0.4, 200.0), _VLP32C_AZIMUTH_DEG
)
XT16 = _model(
    "XT16", HESAI, 15.0 - 2.0 * np.arange(16), 5.632 + 0.368 + 3.024 * np.arange(16), 50.0, (0.05, 120.0)
)
XT32 = _model("XT32", HESAI, 15.0 - np.arange(32), 5.632 + 0.368 + 1.512 * np.arange(32), 50.0, (0.05, 120.0))
PANDAR40P = _model(
    "Pandar40P", HESAI, _PANDAR40P_DEG, np.asarray(_PANDAR40P_US) - 28.58, 55.56, (0.3, 200.0),
    _PANDAR40P_AZIMUTH_DEG,
)  # fmt: skip
PANDAR64 = _model(
    "Pandar64", HESAI, _PANDAR64_DEG, np.asarray(_PANDAR64_US) - 42.58, 55.56, (0.3, 200.0),
    _PANDAR64_AZIMUTH_DEG,
)  # fmt: skip

MODELS = {
    model.name: model for model in (VLP16, PUCK_HI_RES, HDL32E, VLP32C, XT16, XT32, PANDAR40P, PANDAR64)
}
