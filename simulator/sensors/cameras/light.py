"""What lights the scene of a camera, and what stands between the scene and the picture."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from simulator.sensors.scene.changes import SceneError


@dataclass(frozen=True, slots=True)
class Light:
    """Sun, sky and lamps; reflected light is relative to the sky's on a level white ground by day.

    sun_azimuth_rad, sun_height_rad  where the sun stands, map frame; below the horizon there is none
    sun         its light on a surface at right angles; 0.0 under an overcast sky
    sky         light of the whole sky
    headlights  light of the vehicle's own lamps at 10 m ahead; 0.0 without
    glare_ratio share of the sun's light that the lens scatters over the picture when it looks there
    rain_mm_per_h  drops in front of the lens, streaks, and less contrast far away
    noise       standard deviation of the sensor's noise at full exposure, of 255
    exposure_max  greatest gain: at night the picture stays dark and noisy
    """

    sun_azimuth_rad: float = 0.8
    sun_height_rad: float = 0.9
    sun: float = 1.2
    sky: float = 0.8
    headlights: float = 0.0
    glare_ratio: float = 0.0
    rain_mm_per_h: float = 0.0
    noise: float = 1.5
    exposure_max: float = 40.0

    def __post_init__(self) -> None:
        """Raises SceneError for light that is negative, or rain above 200 mm/h."""
        amounts = (self.sun, self.sky, self.headlights, self.glare_ratio, self.noise)
        if min(amounts) < 0.0 or self.exposure_max < 1.0 or not 0.0 <= self.rain_mm_per_h <= 200.0:
            raise SceneError(f"light must not be negative, exposure_max 1 or more, rain 0 to 200, not {self}")

    @property
    def to_sun(self) -> Array:
        """(3,) unit vector from the scene to the sun."""
        level = math.cos(self.sun_height_rad)
        return np.array(
            [
                level * math.cos(self.sun_azimuth_rad),
                level * math.sin(self.sun_azimuth_rad),
                math.sin(self.sun_height_rad),
            ]
        )

    @property
    def has_sun(self) -> bool:
        return self.sun > 0.0 and self.sun_height_rad > 0.0


DAY = Light()
OVERCAST = Light(sun=0.0, sky=1.0)
LOW_SUN = Light(sun_azimuth_rad=0.0, sun_height_rad=0.15, sun=1.0, sky=0.5, glare_ratio=0.6)
NIGHT = Light(sun=0.0, sky=0.002, headlights=0.08, noise=4.0)
RAIN = Light(sun=0.0, sky=0.6, rain_mm_per_h=20.0)
