"""The planner's picture of people beside recorded people: `python -m benchmarks.predictions DIR [--json F]`.

For the recordings that parameters may be tuned on and for the others (the split of `benchmarks.people`), at
horizons from 0.5 to 3 s and for people who stand or dawdle (below 0.8 m/s) and people who walk:

- the sudden step: fitted on the first part, and which share of the deviations across it covers;
- the standard deviation that the predictor assigns: which share of deviations is within one and within two;
- a pace that people come back to, fitted on the first part: its errors beside those of constant velocity.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks.people.samples import fitted_recordings
from benchmarks.predictions.deviations import HORIZONS_S, Deviations, deviations
from benchmarks.predictions.fitting import (
    covered,
    fitted_pace,
    fitted_step,
    paced_m,
    rms_m,
    within_sigmas,
)
from benchmarks.reporting.report import Row, RunReport, Value
from contract.geometry import Array
from simulator.traffic.recordings import RecordingError, drone_clips
from vehicle_agent.planning.motion.request import StoppingRoom
from vehicle_agent.world.prediction import Predictor

WALKS_MPS = 0.8


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    try:
        clips = drone_clips(arguments.folder)
    except RecordingError as error:
        raise SystemExit(f"cannot read: {error}") from error
    fitted = fitted_recordings()
    parts = {
        name: deviations(chosen)
        for name, chosen in (
            ("fit", [clip for clip in clips if clip.name in fitted]),
            ("held_out", [clip for clip in clips if clip.name not in fitted]),
        )
        if chosen
    }
    if "fit" not in parts:
        raise SystemExit("cannot fit: the folder has none of the recordings that split.json names")
    step, pace = fitted_step(parts["fit"]), fitted_pace(parts["fit"])
    summary: dict[str, Value] = {
        "step_mps": step.mps,
        "step_rise_s": step.rise_s,
        "pace_mps": pace[0],
        "pace_relax_s": pace[1],
    }
    print(f"fitted step: {step.mps:.2f} m/s, {step.rise_s:.2f} s; the planner has {StoppingRoom().step}")
    rows: list[Row] = []
    for name, found in parts.items():
        slow = found.speed_mps < WALKS_MPS
        for kind, chosen in (("stand, dawdle", slow), ("walk", ~slow)):
            rows += _rows(name, kind, found.where(chosen), pace)
    report.write(arguments.json, "predictions", {"folder": str(arguments.folder)}, rows, summary)


def _rows(part: str, people: str, found: Deviations, pace: tuple[float, float]) -> list[Row]:
    """A row for each horizon."""
    predictor = Predictor()
    sigma = predictor.position_std_m + predictor.person_std_mps * np.array(HORIZONS_S)
    one, two = within_sigmas(found, sigma, 1.0), within_sigmas(found, sigma, 2.0)
    columns: Mapping[str, Array] = {
        "observations": np.isfinite(found.along_m).sum(axis=0).astype(np.float64),
        "step_covers": covered(found, StoppingRoom().step),
        "sigma_m": sigma,
        "along_in_1_sigma": one[0],
        "across_in_1_sigma": one[1],
        "along_in_2_sigma": two[0],
        "across_in_2_sigma": two[1],
        "along_mean_m": np.nanmean(found.along_m, axis=0),
        "along_rms_m": rms_m(found.along_m),
        "paced_rms_m": rms_m(found.along_m - paced_m(found.speed_mps, *pace)),
    }
    return [
        {"part": part, "people": people, "horizon_s": t}
        | {name: float(values[k]) for name, values in columns.items()}
        for k, t in enumerate(HORIZONS_S)
    ]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.predictions", description=__doc__)
    parser.add_argument("folder", type=Path, help="drone recordings")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
