"""Forward acceleration and yaw rate: noise, a bias that walks, a scale error of the gyroscope.

The six axes of a strapdown unit are in `inertial_unit.py`.
"""

import math
from dataclasses import dataclass

import numpy as np

from simulator.vehicle.plant import GRAVITY_MPS2, PlantView
from vehicle_agent.signals import ImuSample


@dataclass(frozen=True, slots=True)
class ImuNoise:
    """Standard deviations; each sensor's first bias and scale error are drawn once.

    yaw_rate_walk_radps  growth of the gyroscope's bias, per square root of a second
    gravity              an accelerometer measures the specific force, so that a slope shows in it as
                         acceleration; off: the receiver has taken gravity out by an attitude of its own
    """

    accel_std_mps2: float = 0.05
    yaw_rate_std_radps: float = 0.003
    accel_bias_std_mps2: float = 0.01
    yaw_rate_bias_std_radps: float = 0.0005
    yaw_rate_walk_radps: float = 0.0
    yaw_rate_scale_std: float = 0.0
    gravity: bool = False


class Imu:
    """One vehicle's inertial sensor."""

    def __init__(self, noise: ImuNoise, rng: np.random.Generator) -> None:
        self._noise, self._rng = noise, rng
        self._accel_bias_mps2 = float(rng.standard_normal()) * noise.accel_bias_std_mps2
        self._yaw_rate_bias_radps = float(rng.standard_normal()) * noise.yaw_rate_bias_std_radps
        self._scale = 1.0
        if noise.yaw_rate_scale_std > 0.0:
            self._scale += float(rng.standard_normal()) * noise.yaw_rate_scale_std
        self._last_ns: int | None = None

    def sample(self, now_ns: int, truth: PlantView) -> ImuSample:
        accel, yaw_rate = self._rng.standard_normal(2).tolist()
        self._walk(now_ns)
        force_mps2 = truth.accel_mps2
        if self._noise.gravity:
            force_mps2 += GRAVITY_MPS2 * math.sin(math.atan(truth.grade_ratio))
        return ImuSample(
            now_ns,
            force_mps2 + self._accel_bias_mps2 + accel * self._noise.accel_std_mps2,
            self._scale * truth.yaw_rate_radps
            + self._yaw_rate_bias_radps
            + yaw_rate * self._noise.yaw_rate_std_radps,
        )

    def _walk(self, now_ns: int) -> None:
        if self._noise.yaw_rate_walk_radps > 0.0 and self._last_ns is not None:
            growth = self._noise.yaw_rate_walk_radps * math.sqrt((now_ns - self._last_ns) * 1e-9)
            self._yaw_rate_bias_radps += growth * float(self._rng.standard_normal())
        self._last_ns = now_ns
