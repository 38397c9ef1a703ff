"""CPU time of the Snow Lion stack's control in a tick: `python -m benchmarks.mpc --json F [--steps N]`.

One continuous drive over CAN on the simulated shuttle with tyres, noise and steering bias: straights at 4.2
m/s, curves and tight bends, crawling, stops and standing, repeated. The last fifth of the steps is driven
with the steering rate limited to 1 degree a second, about the rate of its bends, so that the bound is often
met. A step is the room's whole `step`: observer, projection, lead, both problems (N = 40) and pedals.
`infeasible` also counts problems that the solver did not finish.
"""

import argparse
import gc
import math
import os
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.tracking.reference_paths import ReferencePath
from benchmarks.tracking.sensing import noisy
from benchmarks.tracking.timed_drive import SpeedRule, TimedRun, follow_timed, timed_rows
from contract.geometry import Array, arc_lengths
from simulator.sensors.gnss import GnssNoise
from simulator.vehicle.plant import PlantParams
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.control.trajectory.trajectory_control import TrajectoryControl
from vehicle_agent.stacks.snow_lion_control import control

QUANTILES = (50, 95, 99)
SLOW_WHEEL_RADPS = math.radians(1.0)
STAND_S = 3.0
# (metres, curvature at their beginning, at their end) one after the other, and the speed meant for them.
Bend = tuple[float, float, float]
LEGS: tuple[tuple[float, tuple[Bend, ...]], ...] = (
    (4.2, ((45.0, 0.0, 0.0),)),
    (
        3.0,
        ((6.0, 0.0, 0.05), (20.0, 0.05, 0.05), (12.0, 0.05, -0.05), (20.0, -0.05, -0.05), (6.0, -0.05, 0.0)),
    ),
    (1.5, ((4.0, 0.0, 0.18), (6.0, 0.18, 0.18), (4.0, 0.18, 0.0), (10.0, 0.0, 0.0))),
    (0.3, ((5.0, 0.0, 0.0),)),
)
# Bends at about the rate that the slow wheel can turn, so that corrections meet the bound.
MILD_LEGS: tuple[tuple[float, tuple[Bend, ...]], ...] = (
    (
        3.0,
        (
            (20.0, 0.0, 0.0),
            (6.0, 0.0, 0.012),
            (10.0, 0.012, 0.012),
            (12.0, 0.012, -0.012),
            (20.0, -0.012, 0.0),
        ),
    ),
    (1.5, ((5.0, 0.0, 0.0), (6.5, 0.0, 0.03), (4.0, 0.03, 0.03), (13.0, 0.03, -0.03), (15.0, -0.03, 0.0))),
)
_PROFILES = Path(__file__).resolve().parent.parent / "vehicle_agent" / "profiles"


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    profile = load_profile(arguments.profile)
    limited = arguments.steps // 5
    controller = control(profile)
    warm = course(LEGS, 500)
    # Garbage collection of the report's data would disturb the measurements.
    gc.disable()
    follow_timed(warm, profile, controller, _plant(), noisy(arguments.seed, GnssNoise(), profile), 0.0)
    runs = {
        "whole steering rate": _drive(LEGS, arguments.steps - limited, profile, controller, arguments.seed),
        "1 degree a second": _drive(MILD_LEGS, limited, profile, _slow(profile), arguments.seed + 1),
    }
    rows = [_row(name, run) for name, run in runs.items()]
    cpu_ms = 1e3 * np.concatenate([run.step_cpu_s for run in runs.values()])
    wall_ms = 1e3 * np.concatenate([run.step_wall_s for run in runs.values()])
    summary: dict[str, float | int] = {"steps": len(cpu_ms)}
    for q in QUANTILES:
        summary[f"p{q}_cpu_ms"] = float(np.percentile(cpu_ms, q))
        summary[f"p{q}_wall_ms"] = float(np.percentile(wall_ms, q))
    summary["infeasible"] = sum(run.state.infeasible for run in runs.values())
    plain = {"profile": str(arguments.profile), "steps": arguments.steps, "seed": arguments.seed}
    report.write(arguments.json, "mpc", {**plain, "cores_used": 1}, rows, summary)


def course(legs: tuple[tuple[float, tuple[Bend, ...]], ...], steps: int) -> Array:
    """(k, 8) timed rows of the legs over and over for `steps` ticks, standing STAND_S between them."""
    x_m, y_m, yaw_rad, began_s, gone_m = 0.0, 0.0, 0.0, 0.0, 0.0
    parts: list[Array] = []
    number = 0
    while began_s < steps * 0.02:
        speed_mps, bends = legs[number % len(legs)]
        path = _bent(bends, x_m, y_m, yaw_rad, f"leg {number}")
        rows = timed_rows(path, SpeedRule(speed_mps, 0.6, 0.8, 0.6))
        rows[:, 0] += began_s
        rows[:, 7] += gone_m
        rows[:, 3] += 2.0 * math.pi * round((yaw_rad - rows[0, 3]) / (2.0 * math.pi))
        parts.append(rows)
        x_m, y_m, yaw_rad, gone_m = rows[-1, [1, 2, 3, 7]].tolist()
        began_s = float(rows[-1, 0]) + STAND_S
        number += 1
    whole: Array = np.vstack(parts)
    return whole


def _bent(bends: tuple[Bend, ...], x_m: float, y_m: float, yaw_rad: float, name: str) -> ReferencePath:
    step_m = 0.02
    kappa = np.concatenate([np.linspace(a, b, round(m / step_m)) for m, a, b in bends])
    yaw = yaw_rad + np.concatenate(([0.0], np.cumsum(kappa) * step_m))
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    x = x_m + np.concatenate(([0.0], np.cumsum(np.cos(middle)) * step_m))
    y = y_m + np.concatenate(([0.0], np.cumsum(np.sin(middle)) * step_m))
    points = np.column_stack((x, y))
    return ReferencePath(name, points, arc_lengths(points), False)


def _drive(
    legs: tuple[tuple[float, tuple[Bend, ...]], ...],
    steps: int,
    profile: Profile,
    controller: TrajectoryControl,
    seed: int,
) -> TimedRun:
    rows = course(legs, steps)
    return follow_timed(rows, profile, controller, _plant(), noisy(seed, GnssNoise(), profile), 0.0)


def _plant() -> PlantParams:
    return PlantParams(tyres=True, steer_bias_rad=math.radians(0.6), load_kg=140.0)


def _slow(profile: Profile) -> TrajectoryControl:
    """Control for a steering that turns by SLOW_WHEEL_RADPS at most."""
    limits = msgspec.structs.replace(profile.limits, steer_rate_radps_max=SLOW_WHEEL_RADPS)
    return control(msgspec.structs.replace(profile, limits=limits))


def _row(name: str, run: TimedRun) -> Row:
    diagnostics = [dict(command.diagnostics) for command in run.commands]
    times = {
        f"p{q}_{kind}_ms": float(np.percentile(1e3 * values, q))
        for kind, values in (("cpu", run.step_cpu_s), ("wall", run.step_wall_s))
        for q in QUANTILES
    }
    return {
        "part": name,
        "steps": run.drive.ticks,
        **times,
        "max_cpu_ms": float(1e3 * run.step_cpu_s.max()),
        "bound_met": run.state.bounded,
        "infeasible": run.state.infeasible,
        "standing_ratio": float(np.mean(run.drive.trace[:, 4] == 0.0)),
        "not_followed": sum(values["path_fault"] != 0.0 for values in diagnostics),
        "peak_offset_m": max(abs(values["offset_m"]) for values in diagnostics),
    }


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.mpc", description=__doc__)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--steps", type=int, default=100_000, help="ticks, a fifth of them with a slow wheel")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--profile", type=Path, default=_PROFILES / "campus-shuttle.toml")
    return parser.parse_args()


if __name__ == "__main__":
    main()
