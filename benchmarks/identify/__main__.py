"""Identification of unknown vehicles: `python -m benchmarks.identify [--plants 200] --json F`.

Every plant is drawn from its seed (`simulator/vehicle/random_plant.py`), drives the identification drive of
five minutes once, and is identified from it, beginning with the nominal profile. A row compares what the
profile states with the plant. The summary has the share of plants within the tolerances and within half:

delay       dead times of steering, throttle and brake, each within 20 ms
brake_map   the deceleration of each pedal that brakes at 0.5 to 3 m/s2, within 5 %, at the drive's mean
            braking speed
wheelbase   within 2 cm
bias        of the steering, within 0.1 degrees

honest_pct is the share of dead times, wheelbases and biases within two of their stated standard deviations.
"""

import argparse
import math
import time
from pathlib import Path

import numpy as np

from benchmarks.identify.plant_drives import drive_plants
from benchmarks.reporting.report import Row, RunReport
from simulator.vehicle.plant import PlantParams, brake_force_mps2
from simulator.vehicle.random_plant import random_plant
from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.identification.drive_signals import DriveSignals, IdentificationError
from vehicle_agent.identification.identify import Identification, identify

_PROFILE = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles" / "campus-shuttle.toml"
TOLERANCES = {"delay_ms": 20.0, "brake_map_pct": 5.0, "wheelbase_cm": 2.0, "bias_deg": 0.1}
_DECELS_MPS2 = (0.5, 3.0)
_BATCH = 50


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    profile = load_profile(arguments.profile)
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.plants)
    rows: list[Row] = []
    for first in range(0, len(seeds), _BATCH):
        batch = tuple(seeds[first : first + _BATCH])
        plants = tuple(random_plant(profile, seed) for seed in batch)
        for seed, plant, drive in zip(
            batch, plants, drive_plants(profile, plants, batch, arguments.duration_s), strict=True
        ):
            rows.append(_row(seed, plant, drive, profile))
            print(rows[-1], flush=True)
    report.write(
        arguments.json,
        "identify",
        {
            "plants": arguments.plants,
            "first_seed": arguments.first_seed,
            "duration_s": arguments.duration_s,
            "profile": str(arguments.profile),
        },
        rows,
        summary(rows),
    )


def _row(seed: int, plant: PlantParams, drive: DriveSignals, profile: Profile) -> Row:
    begun_s = time.process_time()
    try:
        found = identify(drive, profile)
    except IdentificationError as error:
        return {"seed": seed, "refused": error.code}
    response = found.profile.response
    delays_ms = {
        name: 1e3 * (getattr(response, f"{name}_dead_s") - getattr(plant, f"{name}_delay_s"))
        for name in ("steer", "throttle", "brake")
    }
    return {
        "seed": seed,
        "refused": "",
        **{f"{name}_delay_ms": error for name, error in delays_ms.items()},
        "delay_ms": max(abs(error) for error in delays_ms.values()),
        "brake_map_pct": brake_map_error_pct(found, plant),
        "wheelbase_cm": 100.0 * abs(found.profile.body.wheelbase_m - plant.wheelbase_m),
        "bias_deg": math.degrees(abs(response.steer_bias_rad - plant.steer_bias_rad)),
        "within_2_std": _within_stds(found, plant),
        "cpu_s": time.process_time() - begun_s,
    }


def brake_map_error_pct(found: Identification, plant: PlantParams) -> float:
    """The greatest deviation of the map's deceleration from the plant's, over its pedals, in percent."""
    response, row = found.profile.response, plant.row()
    brakes = BrakeMap(response.brake_gain, response.brake_offset, response.brake_knee_mps2)
    lightness = plant.mass_kg / (plant.mass_kg + plant.load_kg)
    worst = 0.0
    for pedal in np.linspace(0.05, 1.0, 200):
        true_mps2 = lightness * brake_force_mps2(float(pedal), found.pedals.mean_mps, row)
        if _DECELS_MPS2[0] <= true_mps2 <= _DECELS_MPS2[1]:
            mapped_mps2 = math.exp((pedal - brakes.offset) / brakes.gain) - brakes.knee_mps2
            worst = max(worst, abs(mapped_mps2 / true_mps2 - 1.0))
    return 100.0 * worst


def _within_stds(found: Identification, plant: PlantParams) -> float:
    """The share of values whose error is at most two standard deviations."""
    truths = {
        "steer_dead_s": plant.steer_delay_s,
        "throttle_dead_s": plant.throttle_delay_s,
        "brake_dead_s": plant.brake_delay_s,
        "steer_bias_rad": plant.steer_bias_rad,
        "wheelbase_m": plant.wheelbase_m,
    }
    inside = [
        abs(value.value - truths[value.name]) <= 2.0 * value.std
        for value in found.values
        if value.name in truths
    ]
    return sum(inside) / len(inside)


def summary(rows: list[Row]) -> Row:
    """Shares of all plants in percent; a refused one is within no tolerance."""
    accepted = [row for row in rows if not row["refused"]]
    out: dict[str, float | int | None] = {"plants": len(rows), "refused": len(rows) - len(accepted)}
    for key, tolerance in TOLERANCES.items():
        errors = [_number(row[key]) for row in accepted]
        out[f"{key}.within_pct"] = 100.0 * sum(error <= tolerance for error in errors) / len(rows)
        out[f"{key}.within_half_pct"] = 100.0 * sum(error <= 0.5 * tolerance for error in errors) / len(rows)
        out[f"{key}.p95"] = float(np.percentile(errors, 95)) if errors else None
        out[f"{key}.max"] = max(errors) if errors else None
    inside = [_number(row["within_2_std"]) for row in accepted]
    out["honest_pct"] = 100.0 * float(np.mean(inside)) if inside else None
    return out


def _number(value: object) -> float:
    assert isinstance(value, int | float)
    return float(value)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.identify", description=__doc__)
    parser.add_argument("--plants", type=int, default=200)
    parser.add_argument("--first-seed", type=int, default=100, help="0 to 99 are those that it was tuned on")
    parser.add_argument("--duration-s", type=float, default=300.0, help="of each drive")
    parser.add_argument("--profile", type=Path, default=_PROFILE, help="the vehicle's profile before")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
