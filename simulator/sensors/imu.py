"""Forward acceleration and yaw rate, with noise and a constant bias."""

from dataclasses import dataclass

import numpy as np

from simulator.vehicle.plant import PlantView
from vehicle_agent.signals import ImuSample


@dataclass(frozen=True, slots=True)
class ImuNoise:
    """Standard deviations; each sensor's bias is drawn once."""

    accel_std_mps2: float = 0.05
    yaw_rate_std_radps: float = 0.003
    accel_bias_std_mps2: float = 0.01
    yaw_rate_bias_std_radps: float = 0.0005


class Imu:
    """One vehicle's inertial sensor."""

    def __init__(self, noise: ImuNoise, rng: np.random.Generator) -> None:
        self._noise, self._rng = noise, rng
        self._accel_bias_mps2 = float(rng.standard_normal()) * noise.accel_bias_std_mps2
        self._yaw_rate_bias_radps = float(rng.standard_normal()) * noise.yaw_rate_bias_std_radps

    def sample(self, now_ns: int, truth: PlantView) -> ImuSample:
        accel, yaw_rate = self._rng.standard_normal(2).tolist()
        return ImuSample(
            now_ns,
            truth.accel_mps2 + self._accel_bias_mps2 + accel * self._noise.accel_std_mps2,
            truth.yaw_rate_radps + self._yaw_rate_bias_radps + yaw_rate * self._noise.yaw_rate_std_radps,
        )
