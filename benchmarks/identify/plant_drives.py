"""Identification drives of many plants at once, without CAN bytes: a drive takes milliseconds.

Commands, reports and sensors are those of a run log: 50 Hz commands, 30 Hz reports in the steps of the
PACMod3 signals, localization and gyroscope with the simulator's noise. A test drives the same plant through
CAN, gate and run log and compares what is identified.
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, Pose2
from simulator.ecus.module import REPORT_PERIOD_NS
from simulator.fleet import STEP_NS
from simulator.sensors.gnss import GnssNoise
from simulator.sensors.imu import ImuNoise
from simulator.vehicle.plant import (
    CMD_BRAKE,
    CMD_DIRECTION,
    CMD_RATE,
    CMD_STEER,
    CMD_THROTTLE,
    SPEED,
    STEER,
    YAW,
    YAW_RATE,
    Plant,
    PlantParams,
)
from vehicle_agent.config import Profile
from vehicle_agent.control.excitation.pedal_program import program_pedals
from vehicle_agent.identification.drive_signals import DriveSignals
from vehicle_agent.stacks.identification import pedal_program

_SPEED_STEP_MPS = 0.01
_WHEEL_STEP_RAD = 0.001
# Localization averages its fixes; errors of the heading are correlated over this time.
_HEADING_CORRELATION_S = 0.2


def drive_plants(
    profile: Profile, plants: tuple[PlantParams, ...], seeds: tuple[int, ...], duration_s: float
) -> list[DriveSignals]:
    """One identification drive of each plant. seeds: of the noise of each drive."""
    n, ticks, dt_s = len(plants), round(duration_s * 1e9 / STEP_NS), STEP_NS * 1e-9
    plant = Plant(plants, (Pose2(0.0, 0.0, 0.0),) * n)
    plant.commands[:, CMD_DIRECTION] = 1.0
    plant.commands[:, CMD_RATE] = profile.limits.steer_rate_radps_max
    program = pedal_program(profile)
    states = np.zeros((n, len(program.initial())))
    throttles, brakes = np.array(program.throttle_ratios), np.array(program.brake_ratios)
    lock_rad = math.atan(profile.body.wheelbase_m / profile.body.turn_radius_m_min)
    ratio = profile.steering.linear
    commands, truth = np.zeros((ticks, n, 3)), np.zeros((ticks, n, 4))
    reports: list[int] = []
    due_ns = STEP_NS
    for tick in range(ticks):
        now_ns = (tick + 1) * STEP_NS
        truth[tick] = plant.state[:, [SPEED, STEER, YAW, YAW_RATE]]
        if now_ns >= due_ns:
            reports.append(tick)
            due_ns += REPORT_PERIOD_NS
        _drive(
            states,
            plant.state,
            tick * dt_s,
            0.7 * lock_rad,
            dt_s,
            throttles,
            brakes,
            program.row(),
            commands[tick],
        )
        plant.commands[:, CMD_STEER] = commands[tick, :, 0]
        plant.commands[:, CMD_THROTTLE] = commands[tick, :, 1]
        plant.commands[:, CMD_BRAKE] = commands[tick, :, 2]
        plant.step(dt_s)
    tick_s = dt_s * np.arange(1, ticks + 1)
    return [
        _sensed(tick_s, commands[:, i], truth[:, i], np.array(reports), ratio, seeds[i]) for i in range(n)
    ]


@njit(cache=True)
def _drive(
    states: Array, plant: Array, t_s: float, steer_max: float, dt_s: float, throttles: Array, brakes: Array,
    p: Array, commands: Array,
) -> None:  # fmt: skip
    """Fills commands (n, 3): the pedals' program, and curves both ways of changing radius."""
    swing = math.sin(2.0 * math.pi * t_s / 23.0)
    steer = steer_max * (0.55 + 0.45 * math.sin(2.0 * math.pi * t_s / 97.0)) * swing
    for i in range(plant.shape[0]):
        throttle, brake = program_pedals(states[i], plant[i, SPEED], dt_s, throttles, brakes, p)
        commands[i, 0], commands[i, 1], commands[i, 2] = steer, throttle, brake


def _sensed(
    tick_s: Array, commands: Array, truth: Array, reports: Array, wheel_ratio: float, seed: int
) -> DriveSignals:
    """The drive as a run log states it; truth (n, 4): speed, wheel angle, heading, yaw rate."""
    rng = np.random.default_rng([seed, *b"identification drive"])
    gnss, imu = GnssNoise(), ImuNoise()
    n = len(tick_s)
    bias = float(rng.standard_normal()) * imu.yaw_rate_bias_std_radps
    yaw_rate = truth[:, 3] + bias + imu.yaw_rate_std_radps * rng.standard_normal(n)
    share = 0.02 / _HEADING_CORRELATION_S
    noise = np.zeros(n)
    fresh = rng.standard_normal(n) * gnss.heading_std_rad
    for k in range(1, n):
        noise[k] = noise[k - 1] + share * (fresh[k] - noise[k - 1])
    speed = np.round(truth[reports, 0] / _SPEED_STEP_MPS) * _SPEED_STEP_MPS
    step_rad = _WHEEL_STEP_RAD / wheel_ratio
    steer = np.round(truth[reports, 1] / step_rad) * step_rad
    return DriveSignals(
        tick_s, commands, np.ones(n, dtype=bool), yaw_rate, truth[:, 2] + noise, tick_s[reports], speed, steer
    )
