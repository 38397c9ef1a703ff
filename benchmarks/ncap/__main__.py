"""Consumer-test cells with road users in the way: `python -m benchmarks.ncap --json F [--traces DIR]`.

People, cyclists and scooters who cross, run, come from behind parked cars and walk ahead, riders who overtake
and get in the way, and cars that reverse, at 5 to 20 km/h, by day and by night. The shuttle drives each cell
with its whole onboard loop; each cell draws its vehicle (`simulator/vehicle/random_plant.py`). It is compared
with an oracle that brakes as hard as it can as soon as the target is in sight and shows what it will do
(0.27 s, 5.6 m/s2): a contact that it avoids is avoidable. Needless hard stops (3 m/s2 and more) are counted
over --street-km of a street where people walk and stand beside the path.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console

from benchmarks.ncap.drives import STREET_M, CellDrive, StreetDrive, StreetResult, drive_cell, drive_street
from benchmarks.reporting.report import Row, RunReport
from benchmarks.reporting.run_logs import add_log_arguments, log_choice
from benchmarks.reporting.workers import add_worker_arguments, worker_campaign
from campusloop.commands.perceiving import tell_lacks
from campusloop.scenes.protection.cells import cells
from campusloop.scenes.stacks import perceiving
from vehicle_agent.config import ProfileError, load_profile

_PROFILE = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles" / "snow-lion.toml"
# Plants of another --seed are other ones.
_PLANTS_APART = 100_000


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    try:
        jobs, streets = list(cell_drives(arguments)), list(street_drives(arguments))
    except ProfileError as error:
        raise SystemExit(f"cannot drive: {error}") from error
    rows: list[Row] = []
    driven: list[StreetResult] = []
    with worker_campaign(arguments) as campaign:
        workers = campaign.size
        for row in campaign.run(drive_cell, jobs):
            rows.append(row)
            print(_line(row), flush=True)
        for street, result in zip(streets, campaign.run(drive_street, streets), strict=True):
            driven.append(result)
            print(
                f"street {street.seed}: {result.hard_stops} hard stops in {result.driven_m:.0f} m",
                flush=True,
            )
    report.write(
        arguments.json,
        "ncap",
        {
            "profile": str(arguments.profile),
            "perception": arguments.perception,
            "every": arguments.every,
            "seed": arguments.seed,
            "plants": arguments.plants,
            "plant_seed": arguments.plant_seed,
            "workers": workers,
            "cluster": arguments.cluster or "",
        },
        rows,
        summary(rows, driven),
    )


def cell_drives(arguments: argparse.Namespace) -> Iterator[CellDrive]:
    """Every Nth cell; a cell has the same vehicle whichever others are driven. Raises ProfileError."""
    profile = perceiving(load_profile(arguments.profile), arguments.perception == "own")
    tell_lacks(Console(), profile)
    logs = log_choice(arguments)
    traces = None if arguments.traces is None else arguments.traces.absolute()
    for number, cell in list(enumerate(cells(profile.body)))[:: arguments.every]:
        yield CellDrive(cell, profile, arguments.seed, _plant_seed(arguments, number), traces, logs)


def street_drives(arguments: argparse.Namespace) -> Iterator[StreetDrive]:
    """Raises ProfileError."""
    profile = perceiving(load_profile(arguments.profile), arguments.perception == "own")
    for number in range(round(1e3 * arguments.street_km / STREET_M)):
        yield StreetDrive(profile, arguments.seed + number, _plant_seed(arguments, number))


def _plant_seed(arguments: argparse.Namespace, number: int) -> int | None:
    """Of the vehicle of a cell or street with this number."""
    if arguments.plant_seed is not None:
        return int(arguments.plant_seed)
    return _PLANTS_APART * int(arguments.seed) + number if arguments.plants == "random" else None


def summary(rows: list[Row], streets: list[StreetResult]) -> Row:
    avoidable = [row for row in rows if row["avoidable"]]
    avoided = sum(bool(row["avoided"]) for row in avoidable)
    worse = 0
    for row in rows:
        least, ours = row["least_impact_mps"], row["impact_mps"]
        worse += isinstance(least, float) and isinstance(ours, float) and ours > 1.1 * least
    driven_m = sum(street.driven_m for street in streets)
    seconds = sum(street.time_s for street in streets)
    return {
        "cells": len(rows),
        "avoidable_cells": len(avoidable),
        "avoidable_avoided_pct": 100.0 * avoided / len(avoidable) if avoidable else None,
        "unavoidable_avoided": sum(bool(row["avoided"]) for row in rows if not row["avoidable"]),
        "unavoidable_worse_than_10_pct": worse,
        "passed_pct": 100.0 * sum(bool(row["passed"]) for row in rows) / len(rows),
        "false_stops": sum(street.hard_stops for street in streets),
        "street_km": driven_m / 1e3,
        "street_mean_kmh": 3.6 * driven_m / seconds if seconds else None,
    }


def _line(row: Row) -> str:
    impact = row["impact_mps"]
    result = "avoided" if row["avoided"] else f"contact at {impact:.2f} m/s"
    return f"{row['cell']}: {result}{'' if row['avoidable'] else ' (unavoidable)'}"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.ncap", description=__doc__)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--traces", type=Path, help="folder for two CSV files a cell")
    parser.add_argument("--profile", type=Path, default=_PROFILE)
    parser.add_argument("--every", type=int, default=1, help="every Nth cell only")
    parser.add_argument("--street-km", type=float, default=10.0, help="driven for needless hard stops")
    add_worker_arguments(parser, workers=2)
    parser.add_argument("--seed", type=int, default=1, help="of sensor noise")
    parser.add_argument(
        "--plants",
        choices=("random", "nominal"),
        default="random",
        help="the vehicles' dynamics: drawn from the seed for each cell and street, or those of the profile",
    )
    parser.add_argument("--plant-seed", type=int, help="one drawn vehicle for all cells and streets")
    parser.add_argument(
        "--perception",
        choices=("tracker", "own"),
        default="tracker",
        help="road users by a tracker of the truth with noise, or found in simulated scans",
    )
    add_log_arguments(parser)
    return parser.parse_args()


if __name__ == "__main__":
    main()
