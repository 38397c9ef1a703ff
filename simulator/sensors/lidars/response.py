"""How a lidar of one maker answers: detection, range noise, intensity, weather."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.scene.changes import SceneError
from vehicle_agent.lidar.models import HESAI, LidarModel

# Slots of the kernel's parameters.
(
    R_RANGE_STD, R_RANGE_10, R_DIVERGENCE, R_DROPOUT, R_BLOOM, R_EXTINCTION, R_RAIN_STD, R_RAIN_CLUTTER,
    R_RANGE_MIN, R_RANGE_MAX, R_SWAY,
) = range(11)  # fmt: skip


@dataclass(frozen=True, slots=True)
class LidarResponse:
    """Datasheet figures of one sensor.

    range_std_m       of one return from a bright surface at right angles
    range_10_m        at which a surface that reflects 10 % is detected every second time
    divergence_rad    of the beam: at a slant a spot covers a span of ranges
    dropout_ratio     of firings that are lost for no visible reason
    bloom_ratio       of firings beside a retro-reflector that return its range
    """

    range_std_m: float = 0.015
    range_10_m: float = 60.0
    divergence_rad: float = 0.003
    dropout_ratio: float = 0.005
    bloom_ratio: float = 0.6

    def __post_init__(self) -> None:
        """Raises SceneError for a value that no sensor has."""
        if not (0.0 <= self.range_std_m <= 1.0 and self.range_10_m > 0.0 and self.divergence_rad >= 0.0):
            raise SceneError(f"range_std_m must be 0 to 1 m, range_10_m positive, not {self}")
        if not (0.0 <= self.dropout_ratio <= 1.0 and 0.0 <= self.bloom_ratio <= 1.0):
            raise SceneError(f"dropout_ratio and bloom_ratio are shares from 0 to 1, not {self}")


# Hesai XT16: 80 m at 10 %, range precision 0.5 cm (1 sigma); Velodyne VLP-16: +-3 cm, typical. Both manuals.
XT16_RESPONSE = LidarResponse(range_std_m=0.006, range_10_m=80.0, divergence_rad=0.002)
VLP16_RESPONSE = LidarResponse()


def response_of(model: LidarModel) -> LidarResponse:
    """The response of a maker's sensors."""
    return XT16_RESPONSE if model.maker == HESAI else VLP16_RESPONSE


def response_row(
    response: LidarResponse, model_range_m: tuple[float, float], rain_mm_per_h: float, sway_m: float
) -> NDArray[np.float32]:
    """The parameters as the kernel takes them.

    Rain after Goodin et al. 2019 (Predicting the Influence of Rain on LIDAR in ADAS), equations 3 and 4: the
    signal loses exp(-2 alpha r) with alpha = 0.01 R^0.6, and the range gets noise of 0.02 r (1 - exp(-R))^2.
    Raises SceneError for negative rain.
    """
    if not 0.0 <= rain_mm_per_h <= 200.0:
        raise SceneError(f"rain must be 0 to 200 mm/h, not {rain_mm_per_h}")
    row: Array = np.zeros(11)
    row[R_RANGE_STD], row[R_RANGE_10] = response.range_std_m, response.range_10_m
    row[R_DIVERGENCE], row[R_DROPOUT] = response.divergence_rad, response.dropout_ratio
    row[R_BLOOM] = response.bloom_ratio
    row[R_RANGE_MIN], row[R_RANGE_MAX] = model_range_m
    row[R_SWAY] = sway_m
    if rain_mm_per_h > 0.0:
        row[R_EXTINCTION] = 0.01 * rain_mm_per_h**0.6
        row[R_RAIN_STD] = 0.02 * (1.0 - np.exp(-rain_mm_per_h)) ** 2
        row[R_RAIN_CLUTTER] = min(0.05, 2e-4 * rain_mm_per_h)
    return row.astype(np.float32)
