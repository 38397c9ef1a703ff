"""A GNSS/INS receiver: the vehicle's position on WGS 84, with noise, and what it says of it."""

import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import wrap_angle
from contract.roads.model import Origin
from contract.roads.projection import unproject
from simulator.sensors.sky import FIXED, Sky, Solution, SolutionFinder
from simulator.vehicle.plant import PlantView
from vehicle_agent.signals import GnssFix

# Errors of a solution wander; reflections change with the walls beside the way.
WANDER_S = 30.0
REFLECTION_S = 8.0
# Of a solution's variance; the rest is white.
WANDER_SHARE = 0.8


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
    """One vehicle's receiver, 50 Hz, under an open sky.

    `silent` stops it (a scenario's outage). `scale` worsens its noise, and it says so. `shift_m` (east,
    north) puts it elsewhere, and it does not know.
    """

    def __init__(self, origin: Origin, noise: GnssNoise, rng: np.random.Generator) -> None:
        self._origin, self._noise, self._rng = origin, noise, rng
        self._drift_m = rng.standard_normal(2) * noise.drift_std_m
        self._drift_ns: int | None = None
        self.silent = False
        self.scale = 1.0
        self.shift_m = (0.0, 0.0)

    def fix(self, now_ns: int, truth: PlantView) -> GnssFix | None:
        """The solution at now_ns, moved to the rear-axle centre, or None while silent."""
        noise, scale = self._noise, self.scale
        self._update_drift(now_ns)
        east, north, heading, speed, yaw_rate = self._rng.standard_normal(5).tolist()
        if self.silent:
            return None
        offset_m = (
            float(self._drift_m[0]) + east * noise.position_std_m * scale,
            float(self._drift_m[1]) + north * noise.position_std_m * scale,
        )
        stated = (math.hypot(noise.position_std_m * scale, noise.drift_std_m), noise.heading_std_rad * scale)
        return self._fix(now_ns, truth, offset_m, heading, (speed, yaw_rate), stated)

    def _fix(
        self,
        now_ns: int,
        truth: PlantView,
        offset_m: tuple[float, float],
        heading: float,
        motion: tuple[float, float],
        stated: tuple[float, float],
    ) -> GnssFix:
        """heading, motion: normal deviates; stated: deviations of position and heading."""
        pose, noise = truth.pose_map, self._noise
        latitude_deg, longitude_deg = unproject(
            self._origin,
            pose.x_m + offset_m[0] + self.shift_m[0],
            pose.y_m + offset_m[1] + self.shift_m[1],
        )
        return GnssFix(
            stamp_ns=now_ns,
            latitude_deg=latitude_deg,
            longitude_deg=longitude_deg,
            heading_rad=wrap_angle(pose.yaw_rad + heading * stated[1]),
            speed_mps=truth.speed_mps + motion[0] * noise.speed_std_mps,
            yaw_rate_radps=truth.yaw_rate_radps + motion[1] * noise.yaw_rate_std_radps,
            position_std_m=stated[0],
            heading_std_rad=stated[1],
        )

    def _update_drift(self, now_ns: int) -> None:
        """Gauss-Markov drift since the last fix."""
        noise = self._noise
        if noise.drift_std_m > 0.0 and self._drift_ns is not None:
            keep = math.exp(-(now_ns - self._drift_ns) * 1e-9 / noise.drift_time_s)
            fresh = noise.drift_std_m * math.sqrt(1.0 - keep * keep)
            self._drift_m = keep * self._drift_m + fresh * self._rng.standard_normal(2)
        self._drift_ns = now_ns


class CampusReceiver(GnssReceiver):
    """A receiver between buildings: the sky decides on its solution. It knows nothing of reflections.

    What it states is what its kind of solution is good for, not the error that it has.
    """

    def __init__(self, origin: Origin, noise: GnssNoise, sky: Sky, rng: np.random.Generator) -> None:
        """noise: of speed and yaw rate alone."""
        super().__init__(origin, noise, rng)
        self._finder = SolutionFinder(sky)
        self._wander = rng.standard_normal(3)
        self._reflection = rng.standard_normal(2)
        self._last_ns: int | None = None

    def fix(self, now_ns: int, truth: PlantView) -> GnssFix | None:
        """The solution at now_ns, or None while silent; without one its deviation is infinite."""
        self._wander_on(now_ns)
        white = self._rng.standard_normal(5)
        solution, view = self._finder.solution(now_ns, truth.pose_map.x_m, truth.pose_map.y_m)
        if self.silent:
            return None
        if solution is None:
            return self._fix(now_ns, truth, (0.0, 0.0), 0.0, (0.0, 0.0), (math.inf, FIXED.heading_std_rad))
        stated = self._stated(solution, view.hdop)
        unit = math.sqrt(WANDER_SHARE) * self._wander[:2] + math.sqrt(1.0 - WANDER_SHARE) * white[:2]
        offset_m = stated[0] * unit + solution.reflection_m * view.walled * self._reflection
        heading = math.sqrt(WANDER_SHARE) * self._wander[2] + math.sqrt(1.0 - WANDER_SHARE) * white[2]
        return self._fix(
            now_ns,
            truth,
            (float(offset_m[0]), float(offset_m[1])),
            float(heading),
            (float(white[3]), float(white[4])),
            stated,
        )

    def _stated(self, solution: Solution, hdop: float) -> tuple[float, float]:
        worse = max(1.0, hdop) * self.scale
        return solution.position_std_m * worse, solution.heading_std_rad * worse

    def _wander_on(self, now_ns: int) -> None:
        dt_s = 0.0 if self._last_ns is None else (now_ns - self._last_ns) * 1e-9
        self._last_ns = now_ns
        for values, time_s in ((self._wander, WANDER_S), (self._reflection, REFLECTION_S)):
            keep = math.exp(-dt_s / time_s)
            values *= keep
            values += math.sqrt(1.0 - keep * keep) * self._rng.standard_normal(len(values))
