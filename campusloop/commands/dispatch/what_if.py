"""`campusloop dispatch what-if`: a day's rides on another fleet, or under another policy."""

import re
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Column, Table

from campusloop.commands.dispatch.ending import JsonPath, refuse, write_json
from campusloop.commands.dispatch.explain import DatabaseUrl
from campusloop.studies.dispatch.day_figures import DayFigures, figures_of
from campusloop.studies.dispatch.fleet_day import (
    POLICIES,
    Policy,
    Shuttle,
    run_day,
)
from campusloop.studies.dispatch.ride_demand import (
    NotOnThisMap,
    booked_between,
    enrolled,
    require_on_map,
)
from campusloop.studies.dispatch.stored_campus import CampusUnread, local_day, stored_campus
from contract.roads.load import MapError, load_map
from contract.roads.network import RoadNetwork
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads
from simulator.demand.day import WantedRide
from simulator.demand.table import RidesUnreadable, read_rides

_CSV_FLEET = 3
_WIDTH, _COLUMN = 32, 24
_CHANGE = re.compile(r"[+-]?\d+")


class CannotTry(ValueError):
    """There is nothing to try with what was given; the text says what to do."""


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
        int | None, typer.Option(help="shuttles to begin with; else those enrolled, or 3 for a CSV")
    ] = None,
    seats: Annotated[int, typer.Option(min=1, help="of each shuttle, where none are enrolled")] = 6,
    wheelchair_places: Annotated[int, typer.Option(min=0, help="likewise")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="of the improvement")] = 1,
    database: DatabaseUrl = None,
    json_path: JsonPath = None,
) -> None:
    """Simulate a day's rides with the fleet as it was and as it could be; print both side by side."""
    errors = Console(stderr=True)
    try:
        policies = [_policy(name) for name in policy or ["improvement"]]
        like = Shuttle("", seats, wheelchair_places)
        rides, roads, shuttles = _day(day, map_path, database, like)
        present = _resized(shuttles, len(shuttles) if fleet is None else fleet, like)
        changed = _resized(present, _count(vehicles, len(present)), present[0])
        fleets = [present] if len(changed) == len(present) else [present, changed]
        trials = _tried(errors, rides, roads, policies, fleets, seed)
    except (CannotTry, CampusUnread, RidesUnreadable, NotOnThisMap) as error:
        refuse(errors, str(error))
    if json_path is None or not write_json(errors, json_path, _report(day, seed, trials)):
        table = _table(day, trials)
        # Into a file or a pipe it goes whole.
        width = None if Console().is_terminal else _WIDTH + _COLUMN * len(trials)
        Console(width=width).print(table)


def _policy(name: str) -> Policy:
    if name not in POLICIES:
        known = "; ".join(f"{policy.name}: {policy.words}" for policy in POLICIES.values())
        raise CannotTry(f"there is no policy {name}; there is {known}")
    return POLICIES[name]


def _day(
    named: str, map_path: Path | None, database: str | None, like: Shuttle
) -> tuple[tuple[WantedRide, ...], FleetRoads, tuple[Shuttle, ...]]:
    """Rides, roads, and the shuttles that there are; for a table a few like that one."""
    path = Path(named)
    if path.is_file() or path.suffix.lower() == ".csv":
        if map_path is None:
            raise CannotTry("a table of rides needs the map of its stops: --map MAP.json")
        try:
            rides = read_rides(path)
        except OSError as error:
            raise CannotTry(f"{path}: {error.strerror}") from error
        roads = _roads(map_path)
        shuttles = (like,) * _CSV_FLEET
    else:
        with stored_campus(database) as uow:
            rides = booked_between(uow, *local_day(uow, named))
            shuttles = enrolled(uow)
            roads = uow.roads() if map_path is None else _roads(map_path)
    if not rides:
        raise CannotTry(f"there are no rides in {named}: nothing to try")
    require_on_map(rides, roads)
    return rides, roads, shuttles


def _roads(map_path: Path) -> FleetRoads:
    rules = FleetRules()
    try:
        return FleetRoads(RoadNetwork(load_map(map_path)), rules.speed_cap_mps, rules.travel_time_factor)
    except MapError as error:
        raise CannotTry(f"{map_path}: {error.detail}") from error


def _count(change: str, present: int) -> int:
    if not _CHANGE.fullmatch(change.strip()):
        raise CannotTry(f"--vehicles {change} is no change of the fleet; write +1, -1, or 5 for five in all")
    number = int(change)
    return present + number if change.strip()[0] in "+-" else number


def _resized(present: tuple[Shuttle, ...], count: int, like: Shuttle) -> tuple[Shuttle, ...]:
    """The first so many, and others like that one. Raises CannotTry for a fleet of nobody."""
    if count < 1:
        raise CannotTry(
            f"a fleet of {count} shuttles drives nobody; say how many with --fleet and --vehicles"
        )
    more = (replace(like, vehicle_id=f"more-{k + 1}") for k in range(len(present), count))
    return (*present[:count], *more)


def _tried(
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
                made = run_day(rides, fleet, roads, FleetRules(), policy, seed, lambda: bar.advance(task))
                trials.append(_Trial(policy, fleet, figures_of(made)))
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
