"""The Snow Lion control on the simulated shuttle: short drives, over CAN, with whatever shall go wrong."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any

import msgspec
import numpy as np

from benchmarks.tracking.reference_paths import ReferencePath
from benchmarks.tracking.sensing import Sensing, noisy, perfect
from benchmarks.tracking.timed_drive import SpeedRule, TimedRun, follow_timed, timed_rows
from contract.geometry import Array, arc_lengths
from simulator.sensors.gnss import GnssNoise
from simulator.vehicle.plant import PlantParams
from vehicle_agent.config import load_profile
from vehicle_agent.control.trajectory.trajectory_control import TrajectoryControl, TrajectoryControlState
from vehicle_agent.signals import ControlCommand, Ego, Path, VehicleMotion
from vehicle_agent.stacks.snow_lion_control import control

PROFILE = load_profile(
    File(__file__).resolve().parents[4] / "vehicle_agent" / "profiles" / "campus-shuttle.toml"
)
HANDS = control(PROFILE)
# Rough as the real one: tyres, and wheels that stand 0.6 degrees beyond what they say.
ROUGH: dict[str, Any] = {"tyres": True, "steer_bias_rad": math.radians(0.6)}

Change = Callable[[int, Ego, Path], tuple[Ego, Path]]


@dataclass(frozen=True, slots=True)
class Tampered:
    """Control that is told something else than what is, by tick number."""

    control: TrajectoryControl
    change: Change

    def initial(self) -> tuple[int, TrajectoryControlState]:
        return 0, self.control.initial()

    def step(
        self, state: tuple[int, TrajectoryControlState], ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, tuple[int, TrajectoryControlState]]:
        ego, path = self.change(state[0], ego, path)
        command, driver = self.control.step(state[1], ego, path, motion)
        return command, (state[0] + 1, driver)


@dataclass(frozen=True, slots=True)
class HeldByAnother:
    """Control whose vehicle another brake holds, as the guard does, until the tick `released`."""

    control: TrajectoryControl
    released: int

    def initial(self) -> tuple[int, TrajectoryControlState]:
        return 0, self.control.initial()

    def step(
        self, state: tuple[int, TrajectoryControlState], ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, tuple[int, TrajectoryControlState]]:
        command, driver = self.control.step(state[1], ego, path, motion)
        if state[0] < self.released:
            command = msgspec.structs.replace(command, throttle_ratio=0.0, brake_ratio=0.5)
        return command, (state[0] + 1, driver)


def straight(length_m: float, radius_m: float = math.inf) -> ReferencePath:
    """A straight to the east, or a left circle."""
    s = np.arange(0.0, length_m + 0.01, 0.02)
    turned = s / radius_m
    if math.isinf(radius_m):
        points = np.column_stack((s, np.zeros_like(s)))
    else:
        points = radius_m * np.column_stack((np.sin(turned), 1.0 - np.cos(turned)))
    return ReferencePath("line", points, arc_lengths(points), False)


def rows_on(path: ReferencePath, speed_mps: float = 3.0, accel_mps2: float = 0.6) -> Array:
    return timed_rows(path, SpeedRule(speed_mps, accel_mps2, 1.0, 1.0))


def driven(
    rows: Array, change: Change | None = None, seed: int | None = 1, settle_s: float = 3.0, **plant: Any
) -> TimedRun:
    """Drive the rows; seed None: perfect localization."""
    control: Any = HANDS if change is None else Tampered(HANDS, change)
    sense: Sensing = perfect if seed is None else noisy(seed, GnssNoise(), PROFILE)
    return follow_timed(rows, PROFILE, control, PlantParams(**(ROUGH | plant)), sense, settle_s)


def said(run: TimedRun, name: str) -> Array:
    """(n,) one diagnostic of every tick."""
    return np.array([dict(command.diagnostics)[name] for command in run.commands])


def within_limits(run: TimedRun) -> bool:
    """Are all commands finite and inside the vehicle's limits, the steering's rate included?"""
    steer = np.array([command.steer_rad for command in run.commands])
    pedals = np.array([(command.throttle_ratio, command.brake_ratio) for command in run.commands])
    mpc = HANDS.steer.mpc
    return bool(
        np.isfinite(steer).all()
        and np.isfinite(pedals).all()
        and np.abs(steer).max() <= mpc.steer_rad_max + 1e-12
        and np.abs(np.diff(steer)).max() <= mpc.steer_rate_radps_max * 0.02 + 1e-9
        and pedals.min() >= 0.0
        and pedals.max() <= 1.0
    )
