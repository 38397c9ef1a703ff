"""A GNSS/INS receiver: the vehicle's position on WGS 84, with noise."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import wrap_angle
from contract.roads.model import Origin
from contract.roads.projection import unproject
from simulator.vehicle.plant import PlantView
from vehicle_agent.signals import GnssFix


@dataclass(frozen=True, slots=True)
class GnssNoise:
    """Standard deviations. `drift_std_m` is a slowly wandering offset (first-order, drift_time_s)."""

    position_std_m: float = 0.02
    heading_std_rad: float = math.radians(0.3)
    speed_std_mps: float = 0.02
    yaw_rate_std_radps: float = 0.002
    drift_std_m: float = 0.0
    drift_time_s: float = 60.0


class GnssReceiver:
    """One vehicle's receiver, 50 Hz. `silent` stops it (a scenario's outage); `scale` worsens its noise."""

    def __init__(self, origin: Origin, noise: GnssNoise, rng: np.random.Generator) -> None:
        self._origin, self._noise, self._rng = origin, noise, rng
        self._drift_m = rng.standard_normal(2) * noise.drift_std_m
        self._drift_ns: int | None = None
        self.silent = False
        self.scale = 1.0

    def fix(self, now_ns: int, truth: PlantView) -> GnssFix | None:
        """The solution at now_ns, moved to the rear-axle centre, or None while silent."""
        noise, scale = self._noise, self.scale
        self._update_drift(now_ns)
        east, north, heading, speed, yaw_rate = self._rng.standard_normal(5).tolist()
        if self.silent:
            return None
        latitude_deg, longitude_deg = unproject(
            self._origin,
            truth.pose_map.x_m + float(self._drift_m[0]) + east * noise.position_std_m * scale,
            truth.pose_map.y_m + float(self._drift_m[1]) + north * noise.position_std_m * scale,
        )
        return GnssFix(
            stamp_ns=now_ns,
            latitude_deg=latitude_deg,
            longitude_deg=longitude_deg,
            heading_rad=wrap_angle(truth.pose_map.yaw_rad + heading * noise.heading_std_rad * scale),
            speed_mps=truth.speed_mps + speed * noise.speed_std_mps,
            yaw_rate_radps=truth.yaw_rate_radps + yaw_rate * noise.yaw_rate_std_radps,
            position_std_m=math.hypot(noise.position_std_m * scale, noise.drift_std_m),
        )

    def _update_drift(self, now_ns: int) -> None:
        """Gauss-Markov drift since the last fix."""
        noise = self._noise
        if noise.drift_std_m > 0.0 and self._drift_ns is not None:
            keep = math.exp(-(now_ns - self._drift_ns) * 1e-9 / noise.drift_time_s)
            fresh = noise.drift_std_m * math.sqrt(1.0 - keep * keep)
            self._drift_m = keep * self._drift_m + fresh * self._rng.standard_normal(2)
        self._drift_ns = now_ns
