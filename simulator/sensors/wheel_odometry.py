"""What the encoders of the rear wheels count along a trajectory: slip, worn tyres, whole ticks."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.lidars.scanner import Trajectory
from simulator.vehicle.plant import GRAVITY_MPS2

_HALF_NS = 5_000_000


@dataclass(frozen=True, slots=True)
class WheelErrors:
    """Errors of one vehicle's wheels; the radii's are drawn once.

    radius_std      true over stated radius, minus 1, of both wheels together
    unequal_std     half the difference of the two, which turns the odometry
    slip_s2pm       share by which driven wheels turn faster per m/s2 of their force
    slip_std        of the slip at one moment, as a share of the speed, correlated over slip_s
    tick_rad        of a wheel's turn between two ticks of its encoder
    """

    radius_std: float = 0.005
    unequal_std: float = 0.001
    slip_s2pm: float = 0.006
    slip_std: float = 0.004
    slip_s: float = 0.5
    tick_rad: float = 2.0 * math.pi / 512.0
    radius_m: float = 0.28
    track_m: float = 1.2


@dataclass(frozen=True, slots=True, eq=False)
class WheelReadings:
    """Since the readings before: stamps_ns (n,), speed_mps (n,) and yaw_rate_radps (n,) by the two wheels."""

    stamps_ns: NDArray[np.int64]
    speed_mps: Array
    yaw_rate_radps: Array


class WheelOdometry:
    """The rear wheels of one vehicle; the same generator state gives the same readings."""

    def __init__(self, errors: WheelErrors, rng: np.random.Generator) -> None:
        self._errors, self._rng = errors, rng
        both, apart = rng.standard_normal(2)
        self._radius = 1.0 + errors.radius_std * both + errors.unequal_std * apart * np.array([1.0, -1.0])
        self._slip = errors.slip_std * rng.standard_normal(2)
        self._turned_rad: Array = np.zeros(2)
        self._ticks: Array = np.zeros(2)
        self._last_ns: int | None = None

    def readings(self, trajectory: Trajectory, stamps_ns: NDArray[np.int64]) -> WheelReadings:
        """The readings at rising times, each over the time since the one before; the very first gives none.

        trajectory  T_map_base (n, 4, 4), asked 5 ms before and after each time, too
        """
        errors = self._errors
        speed, yaw_rate, force = _motion(trajectory, stamps_ns)
        half = 0.5 * errors.track_m
        wheels = np.column_stack((speed - half * yaw_rate, speed + half * yaw_rate))
        driven = np.sign(speed)[:, None] * errors.slip_s2pm * force[:, None]
        rows = []
        for k, stamp_ns in enumerate(stamps_ns.tolist()):
            dt_s = 0.0 if self._last_ns is None else (stamp_ns - self._last_ns) * 1e-9
            keep = math.exp(-dt_s / errors.slip_s)
            fresh = errors.slip_std * math.sqrt(1.0 - keep * keep)
            self._slip = keep * self._slip + fresh * self._rng.standard_normal(2)
            rates = wheels[k] * (1.0 + driven[k] + self._slip) / (errors.radius_m * self._radius)
            self._turned_rad = self._turned_rad + rates * dt_s
            ticks = np.floor(self._turned_rad / errors.tick_rad)
            if self._last_ns is not None and dt_s > 0.0:
                way = (ticks - self._ticks) * errors.tick_rad * errors.radius_m
                rows.append((stamp_ns, 0.5 * way.sum() / dt_s, (way[1] - way[0]) / errors.track_m / dt_s))
            self._ticks, self._last_ns = ticks, stamp_ns
        table = np.array(rows, dtype=np.float64).reshape(-1, 3)
        stamps = np.array([row[0] for row in rows], dtype=np.int64)
        return WheelReadings(stamps, table[:, 1].copy(), table[:, 2].copy())


def _motion(trajectory: Trajectory, stamps_ns: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """Speed ahead, yaw rate, and the wheels' force along the vehicle over its mass, (n,) each."""
    before, now, after = (np.asarray(trajectory(stamps_ns + shift)) for shift in (-_HALF_NS, 0, _HALF_NS))
    half_s = _HALF_NS * 1e-9
    ahead = now[:, :3, 0]
    speed = np.einsum("ni,ni->n", (after - before)[:, :3, 3] / (2.0 * half_s), ahead)
    accel = (after[:, :3, 3] - 2.0 * now[:, :3, 3] + before[:, :3, 3]) / half_s**2
    force = np.einsum("ni,ni->n", accel, ahead) + GRAVITY_MPS2 * ahead[:, 2]
    turn = np.einsum("ni,ni->n", after[:, :3, 0] - before[:, :3, 0], now[:, :3, 1]) / (2.0 * half_s)
    return speed, turn, force
