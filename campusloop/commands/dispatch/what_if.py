"""`campusloop dispatch what-if`: a day's rides with another fleet or another policy."""

import re
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Column, Table

from campusloop.commands.dispatch.explain import DatabaseUrl
from campusloop.commands.dispatch.output import JsonPath, refuse, write_json
from campusloop.studies.dispatch.ride_demand import (
    RideNotOnMap,
    booked_between,
    enrolled,
    require_on_map,
)
from campusloop.studies.dispatch.stored_campus import StoredCampusError, local_day, stored_campus
from contract.roads.load import MapError, load_map
from contract.roads.network import RoadNetwork
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads
from server.usecases.planning.day_figures import DayFigures, figures_of
from server.usecases.planning.fleet_day import (
    POLICIES,
    Policy,
    Shuttle,
    run_day,
)
from simulator.demand.day import WantedRide
from simulator.demand.table import RideTableError, read_rides

_CSV_FLEET = 3
_WIDTH, _COLUMN = 32, 24
_CHANGE = re.compile(r"[+-]?\d+")


class WhatIfInputError(ValueError):
    """The arguments cannot be used; the text says what to do."""


@dataclass(frozen=True, slots=True)
class _Trial:
    policy: Policy
    fleet: tuple[Shuttle, ...]
    figures: DayFigures


def what_if(
    day: Annotated[
        str,
        typer.Argument(metavar="DAY_OR_CSV", help="YYYY-MM-DD of stored rides, or a table of rides (CSV)"),
    ],
    vehicles: Annotated[
        str, typer.Option(metavar="CHANGE", help="+1: one shuttle more, -1: one less, 5: five in all")
    ] = "+0",
    policy: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help=f"one or more of {', '.join(POLICIES)}")
    ] = None,
    map_path: Annotated[
        Path | None, typer.Option("--map", metavar="MAP", help="campus map; needed for a CSV")
    ] = None,
    fleet: Annotated[
        int | None, typer.Option(help="shuttles to begin with; default: those enrolled, or 3 for a CSV")
    ] = None,
    seats: Annotated[int, typer.Option(min=1, help="of each shuttle, where none are enrolled")] = 6,
    wheelchair_places: Annotated[int, typer.Option(min=0, help="likewise")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="of the improvement")] = 1,
    database: DatabaseUrl = None,
    json_path: JsonPath = None,
) -> None:
    """Simulate a day's rides with the present fleet and a changed one, and print both side by side."""
    errors = Console(stderr=True)
    try:
        policies = [_policy(name) for name in policy or ["improvement"]]
        template = Shuttle("", seats, wheelchair_places)
        rides, roads, shuttles = _day(day, map_path, database, template)
        present = _resized(shuttles, len(shuttles) if fleet is None else fleet, template)
        changed = _resized(present, _count(vehicles, len(present)), present[0])
        fleets = [present] if len(changed) == len(present) else [present, changed]
        trials = _run_trials(errors, rides, roads, policies, fleets, seed)
    except (WhatIfInputError, StoredCampusError, RideTableError, RideNotOnMap) as error:
        refuse(errors, str(error))
    if json_path is None or not write_json(errors, json_path, _report(day, seed, trials)):
        table = _table(day, trials)
        # A file or a pipe gets the whole width.
        width = None if Console().is_terminal else _WIDTH + _COLUMN * len(trials)
        Console(width=width).print(table)


def _policy(name: str) -> Policy:
    if name not in POLICIES:
        known = "; ".join(f"{policy.name}: {policy.text}" for policy in POLICIES.values())
        raise WhatIfInputError(f"there is no policy {name}; there is {known}")
    return POLICIES[name]


def _day(
    day_or_csv: str, map_path: Path | None, database: str | None, template: Shuttle
) -> tuple[tuple[WantedRide, ...], FleetRoads, tuple[Shuttle, ...]]:
    """Rides, roads and shuttles; for a CSV _CSV_FLEET shuttles like the template."""
    path = Path(day_or_csv)
    if path.is_file() or path.suffix.lower() == ".csv":
        if map_path is None:
            raise WhatIfInputError("a table of rides needs the map of its stops: --map MAP.json")
        try:
            rides = read_rides(path)
        except OSError as error:
            raise WhatIfInputError(f"{path}: {error.strerror}") from error
        roads = _roads(map_path)
        shuttles = (template,) * _CSV_FLEET
    else:
        with stored_campus(database) as uow:
            rides = booked_between(uow, *local_day(uow, day_or_csv))
            shuttles = enrolled(uow)
            roads = uow.roads() if map_path is None else _roads(map_path)
    if not rides:
        raise WhatIfInputError(f"there are no rides in {day_or_csv}: nothing to try")
    require_on_map(rides, roads)
    return rides, roads, shuttles


def _roads(map_path: Path) -> FleetRoads:
    rules = FleetRules()
    try:
        return FleetRoads(RoadNetwork(load_map(map_path)), rules.speed_cap_mps, rules.travel_time_factor)
    except MapError as error:
        raise WhatIfInputError(f"{map_path}: {error.detail}") from error


def _count(change: str, present: int) -> int:
    if not _CHANGE.fullmatch(change.strip()):
        raise WhatIfInputError(
            f"--vehicles {change} is not a change of the fleet; write +1, -1, or 5 for five in all"
        )
    number = int(change)
    return present + number if change.strip()[0] in "+-" else number


def _resized(present: tuple[Shuttle, ...], count: int, template: Shuttle) -> tuple[Shuttle, ...]:
    """The first `count` shuttles, with copies of the template if there are fewer. Raises WhatIfInputError."""
    if count < 1:
        raise WhatIfInputError(
            f"a fleet of {count} shuttles serves no ride; say how many with --fleet and --vehicles"
        )
    more = (replace(template, vehicle_id=f"more-{k + 1}") for k in range(len(present), count))
    return (*present[:count], *more)


def _run_trials(
    errors: Console,
    rides: tuple[WantedRide, ...],
    roads: FleetRoads,
    policies: list[Policy],
    fleets: list[tuple[Shuttle, ...]],
    seed: int,
) -> list[_Trial]:
    trials = []
    with Progress(console=errors, transient=True) as bar:
        task = bar.add_task("", total=len(rides) * len(policies) * len(fleets))
        for policy in policies:
            for fleet in fleets:
                bar.update(task, description=_title(policy, fleet))
                result = run_day(rides, fleet, roads, FleetRules(), policy, seed, lambda: bar.advance(task))
                trials.append(_Trial(policy, fleet, figures_of(result)))
    return trials


def _title(policy: Policy, fleet: tuple[Shuttle, ...]) -> str:
    return f"{policy.name}, {len(fleet)} shuttle{'s' if len(fleet) > 1 else ''}"


def _table(day: str, trials: list[_Trial]) -> Table:
    table = Table(
        Column("", no_wrap=True), title=f"{trials[0].figures.asked} rides of {day}", title_justify="left"
    )
    for trial in trials:
        table.add_column(_title(trial.policy, trial.fleet).replace(", ", "\n"), justify="right", no_wrap=True)

    def row(label: str, shown: Callable[[DayFigures], str]) -> None:
        table.add_row(label, *(shown(trial.figures) for trial in trials))

    row("served", lambda day: f"{day.served} ({_pct(day.served, day.asked)})")
    row("cancelled before pickup", lambda day: str(day.cancelled))
    row("  with a shuttle on its way", lambda day: str(day.in_vain))
    row("refused", lambda day: str(day.refused))
    for rule in sorted({rule for trial in trials for rule in trial.figures.refused_by}):
        row(f"  {rule}", lambda day, rule=rule: str(day.refused_by.get(rule, 0)))  # type: ignore[misc]
    row("median waiting", lambda day: _minutes(day.wait_median_s))
    row("95 % wait at most", lambda day: _minutes(day.wait_p95_s))
    row("mean time on board", lambda day: _minutes(day.ride_mean_s))
    row("  over the direct drive", lambda day: _ratio(day.ride_over_direct))
    row("driving", lambda day: f"{day.driving_h:.1f} h")
    row("promises kept", lambda day: f"{day.promises_kept} of {day.served}")
    return table


def _pct(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f} %"


def _minutes(seconds: float | None) -> str:
    return "-" if seconds is None else f"{seconds / 60.0:.1f} min"


def _ratio(ratio: float | None) -> str:
    return "-" if ratio is None else f"{ratio:.2f} x"


def _report(day: str, seed: int, trials: list[_Trial]) -> dict[str, Any]:
    return {
        "day": day,
        "seed": seed,
        "trials": [
            {"policy": trial.policy.name, "vehicles": len(trial.fleet), **asdict(trial.figures)}
            for trial in trials
        ],
    }
