"""The model of people who heed a vehicle, beside its data: `python -m benchmarks.people DIR [--fit N]`.

For the recordings that it was fitted on and for the others: how well people reproduce their recorded ways
with the recorded car, how they meet the same car at other times, and how that compares with the recorded
encounters. Beside it, how near people pass before a car that stands, and attentive people of the reactive
crowd before a shuttle that stands. `--fit N` searches the parameters again, on the part that split.json
names.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.people.distributions import Encounters, aware_encounters, joined, recorded_encounters
from benchmarks.people.fitting import fitted, loss_m, people_met
from benchmarks.people.passing import crowd_passes_m, recorded_passes_m
from benchmarks.people.plots import plot_distributions
from benchmarks.people.samples import Drive, drives_of, outline
from benchmarks.reporting.report import Row, RunReport
from contract.geometry import Array
from simulator.traffic.aware.acceptance import accepted_limits
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.reproduction import Reproduction, reproduction, walk
from simulator.traffic.aware.ways import own_ways
from simulator.traffic.recordings import RecordingError

# The car comes this much later than it did, or earlier.
SHIFTS_S = (-2.0, -1.0, 1.0, 2.0)
QUANTILES = (0.5, 0.75, 0.9, 0.95)
PASSES_M_QUANTILES = (0.05, 0.25, 0.5)
CROWD_SEEDS = range(1, 21)


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    try:
        drives = drives_of(arguments.folder)
    except RecordingError as error:
        raise SystemExit(f"cannot read: {error}") from error
    parts = {
        "fit": [drive for drive in drives if drive.is_fitted],
        "held_out": [drive for drive in drives if not drive.is_fitted],
    }
    params = ReactionParams()
    if arguments.fit:
        if not parts["fit"]:
            raise SystemExit("cannot fit: the folder has none of the recordings that split.json names")
        params = fitted(parts["fit"], arguments.fit, arguments.seed, lambda line: print(line, flush=True))
        print(f"fitted: {params}")
    rows: list[Row] = []
    measured = {}
    for name, part in parts.items():
        if part:
            row, shown = _measured(name, part, params)
            rows.append(row)
            measured[name] = shown
    if arguments.plot is not None:
        plot_distributions(arguments.plot, measured)
    rows.append({"part": "reactive_crowd"} | passes_row(crowd_passes_m(CROWD_SEEDS)))
    summary = {f"{row['part']}.{key}": value for row in rows for key, value in row.items() if key != "part"}
    report.write(
        arguments.json,
        "people",
        {"folder": str(arguments.folder), "fit": arguments.fit, "seed": arguments.seed}
        | msgspec.to_builtins(params),
        rows,
        summary,
    )


def _measured(
    name: str, drives: Sequence[Drive], params: ReactionParams
) -> tuple[Row, tuple[Encounters, Encounters]]:
    """The row of one part, and its recorded and simulated encounters."""
    reproductions = [reproduction(drive.clip, drive.car, outline(drive.car), params) for drive in drives]
    recorded, unheeding, aware = [], [], []
    for drive in drives:
        of_recorded, of_unheeding, of_aware = drive_encounters(drive, params, SHIFTS_S)
        recorded.append(of_recorded)
        unheeding += of_unheeding
        aware += of_aware
    was, would, now = joined(recorded), joined(unheeding), joined(aware)
    row: dict[str, float | int | str | None] = {
        "part": name,
        "drives": len(drives),
        "loss_m": loss_m(people_met(drives), params),
        "loss_unheeding_m": loss_m(people_met(drives), params, heeding=False),
    }
    for key in ("deployed_m", "population_m", "recreated_m", "unheeding_m"):
        row[f"displacement_{key}"] = _mean(reproductions, key)
    row["shifted_contacts"] = int((now.gaps_m < 0.0).sum())
    row["shifted_contacts_unheeding"] = int((would.gaps_m < 0.0).sum())
    for measure in ("decels_mps2", "onsets_s", "gaps_m"):
        for label, found in (("recorded", was), ("aware", now)):
            for quantile in QUANTILES:
                row[f"{label}_{measure}_p{100 * quantile:.0f}"] = _quantile(getattr(found, measure), quantile)
    clips = {drive.clip.name: drive.clip for drive in drives}
    return row | passes_row(recorded_passes_m(tuple(clips.values()))), (was, now)


def passes_row(passes_m: Array) -> dict[str, float | int | str | None]:
    """How many people pass before a standing vehicle, and how near; passes_m (n,)."""
    row: dict[str, float | int | str | None] = {"passes": len(passes_m)}
    for quantile in PASSES_M_QUANTILES:
        row[f"passes_m_p{100 * quantile:.0f}"] = _quantile(passes_m, quantile)
    row["passes_within_1m_pct"] = 100.0 * float((passes_m < 1.0).mean()) if len(passes_m) else None
    return row


def drive_encounters(
    drive: Drive, params: ReactionParams, shifts_s: Sequence[float]
) -> tuple[Encounters, list[Encounters], list[Encounters]]:
    """As recorded; and with the car at other times, of people who heed nothing and of people of the model."""
    clip, car = drive.clip, drive.car
    people = [track for track in clip.tracks if not track.is_driven]
    ways = own_ways([(person.times_s, person.states) for person in people])
    limits = accepted_limits(ways, clip.cars(), params)
    as_it_was = walk(people, ways, limits, params, car, clip.ends_s, outline(car))
    unheeding, aware = [], []
    for late_s in shifts_s:
        met = walk(people, ways, limits, params, car, clip.ends_s, outline(car), late_s)
        unheeding.append(recorded_encounters(people, met))
        aware.append(aware_encounters(met))
    return recorded_encounters(people, as_it_was), unheeding, aware


def _mean(reproductions: Sequence[Reproduction], key: str) -> float | None:
    samples: Array = np.concatenate([getattr(each, key) for each in reproductions])
    return float(samples.mean()) if len(samples) else None


def _quantile(values: Array, quantile: float) -> float | None:
    return float(np.quantile(values, quantile)) if len(values) else None


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.people", description=__doc__)
    parser.add_argument("folder", type=Path, help="drone recordings")
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--fit", type=int, default=0, metavar="N", help="search the parameters among N sets")
    parser.add_argument("--seed", type=int, default=1, help="of the search")
    parser.add_argument("--plot", type=Path, help="image file with the distributions")
    return parser.parse_args()


if __name__ == "__main__":
    main()
