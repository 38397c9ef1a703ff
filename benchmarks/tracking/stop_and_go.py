"""Setting off and stopping: `python -m benchmarks.tracking.stop_and_go --json F`.

Among people a shuttle sets off again and again. A plan is safe beside somebody at its own speed, so a vehicle
must not be faster than planned. Vehicles drawn from seeds
(`simulator/vehicle/random_plant.py`), of which Snow Lion's control knows the nominal profile alone, drive a
straight with random set-offs, speeds and stops that are drawn from the same seeds. Figures:

faster_mps  most above the plan's speed within 4 s of a set-off: the first, and those from the fifth on
beyond_m    most beyond the plan's place when it has come to rest, from the fifth stop on
ahead_m     most ahead of the plan's place in the whole drive
"""

import argparse
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.tracking.sensing import noisy
from benchmarks.tracking.timed_drive import ROW_S, follow_timed
from contract.geometry import Array
from simulator.sensors.gnss import GnssNoise
from simulator.vehicle.random_plant import random_plant
from vehicle_agent.config import load_profile
from vehicle_agent.stacks.snow_lion_control import control

_PROFILES = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles"
_SPEEDS_MPS = (0.3, 0.5, 0.8, 1.2, 2.0, 2.8)
_ACCEL_MPS2, _DECEL_MPS2 = (0.35, 0.6), (0.4, 0.9)
_EVEN_S, _STAND_S = (0.5, 3.0), (1.0, 3.0)
# A vehicle needs some stops to be known; what it has learned is judged by the later ones.
_LEARNING_STOPS = 4
_SET_OFF_S, _STOPPED_S = 4.0, 0.9
# The plan stands below this speed, which its smoothing leaves at the ends.
_STANDING_MPS = 0.012


def stop_and_go_rows(seed: int, stops: int) -> Array:
    """(k, 8) rows of `signals.Trajectory` on a straight to the east, drawn from the seed."""
    rng = np.random.default_rng([seed, *b"stop and go"])
    times_s, speeds_mps = [0.0], [0.0]
    for _ in range(stops):
        top_mps = float(rng.choice(_SPEEDS_MPS))
        legs = (
            (top_mps / rng.uniform(*_ACCEL_MPS2), top_mps),
            (rng.uniform(*_EVEN_S), top_mps),
            (top_mps / rng.uniform(*_DECEL_MPS2), 0.0),
            (rng.uniform(*_STAND_S), 0.0),
        )
        for duration_s, after_mps in legs:
            times_s.append(times_s[-1] + float(duration_s))
            speeds_mps.append(after_mps)
    t = np.arange(0.0, times_s[-1], ROW_S)
    padded = np.pad(np.interp(t, times_s, speeds_mps), 1, mode="edge")
    v = np.convolve(padded, (0.25, 0.5, 0.25), "valid")
    v[v < _STANDING_MPS] = v[0] = v[-1] = 0.0
    rows = np.zeros((len(t), 8))
    rows[:, 0], rows[:, 5], rows[:, 6] = t, v, np.gradient(v, t)
    rows[:, 1] = rows[:, 7] = np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * ROW_S)))
    return rows


def judged(trace: Array, rows: Array) -> tuple[Array, Array, float]:
    """(faster_mps of each set-off, beyond_m of each stop, ahead_m) of a drive's trace (n, 7) along rows."""
    t = trace[:, 0]
    faster_mps = trace[:, 4] - np.interp(t, rows[:, 0], rows[:, 5])
    ahead_m = trace[:, 1] - np.interp(t, rows[:, 0], rows[:, 7])
    moves = rows[:, 5] > 0.0
    begins_s, ends_s = rows[1:, 0][moves[1:] & ~moves[:-1]], rows[1:, 0][~moves[1:] & moves[:-1]]
    faster = [faster_mps[(t >= at) & (t < at + _SET_OFF_S)].max() for at in begins_s]
    beyond = [ahead_m[(t >= at) & (t < at + _STOPPED_S)].max() for at in ends_s]
    return np.array(faster), np.array(beyond), float(ahead_m[t > 0.0].max())


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    profile = load_profile(arguments.profile)
    room, noise = control(profile), GnssNoise()
    rows: list[Row] = []
    first, faster, beyond = [], [], []
    for seed in range(arguments.first_plant, arguments.first_plant + arguments.plants):
        plan = stop_and_go_rows(seed, arguments.stops)
        run = follow_timed(plan, profile, room, random_plant(profile, seed), noisy(seed, noise, profile))
        set_offs, stops, ahead_m = judged(run.drive.trace, plan)
        known = dict(run.commands[-1].diagnostics)
        rows.append(
            {
                "seed": seed,
                "finished": run.drive.finished,
                "first_faster_mps": float(set_offs[0]),
                "faster_mps": float(set_offs[_LEARNING_STOPS:].max()),
                "beyond_m": float(stops[_LEARNING_STOPS:].max()),
                "ahead_m": ahead_m,
                "drive_gain": known["drive_gain"],
                "brake_gain": known["brake_gain"],
            }
        )
        first.append(set_offs[0])
        faster += set_offs[_LEARNING_STOPS:].tolist()
        beyond += stops[_LEARNING_STOPS:].tolist()
    summary: Row = {
        "first_faster_mps": float(np.mean(first)),
        "faster_mps": float(np.mean(faster)),
        "faster_p95_mps": float(np.percentile(faster, 95)),
        "beyond_p95_m": float(np.percentile(beyond, 95)),
        "ahead_m": float(np.mean([row["ahead_m"] for row in rows])),
        "finished": all(bool(row["finished"]) for row in rows),
    }
    plain = {
        name: str(value) if isinstance(value, Path) else value for name, value in vars(arguments).items()
    }
    report.write(arguments.json, "stop_and_go", plain, rows, summary)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.tracking.stop_and_go", description=__doc__)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--plants", type=int, default=10)
    parser.add_argument("--first-plant", type=int, default=200, help="seed of the first")
    parser.add_argument("--stops", type=int, default=12)
    parser.add_argument("--profile", type=Path, default=_PROFILES / "campus-shuttle.toml")
    return parser.parse_args()


if __name__ == "__main__":
    main()
