"""`campusloop dispatch demand`: a synthetic day of rides with the statistics of a real campus."""

from datetime import date
from pathlib import Path
from typing import Annotated
from zoneinfo import ZoneInfo

import typer
from rich.console import Console

from campusloop.commands.dispatch.output import refuse
from contract.roads.load import MapError, load_map
from simulator.demand.day import draw_day
from simulator.demand.profile import DemandProfileError, built_in_profile, fit_profile
from simulator.demand.table import write_rides

# A Thursday: the busiest day of the week in the built-in profile.
_DAY = "2026-01-08"
_STOPS_MIN = 2


def demand(
    map_path: Annotated[Path, typer.Option("--map", metavar="MAP", help="campus map whose stops are used")],
    rides: Annotated[int, typer.Option(min=1, help="rides on the day, those cancelled included")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="CSV file to write")],
    seed: Annotated[int, typer.Option(min=0, help="the same seed gives the same file")] = 1,
    day: Annotated[str, typer.Option(help="YYYY-MM-DD: each weekday has its hours")] = _DAY,
    fit: Annotated[
        Path | None, typer.Option(metavar="DIR", help="fit to the aggregates (JSON) in this folder instead")
    ] = None,
) -> None:
    """Draw one day of rides: booking times, stops, party sizes and cancellations."""
    errors = Console(stderr=True)
    try:
        road_map = load_map(map_path)
        profile = built_in_profile() if fit is None else fit_profile(fit)
    except MapError as error:
        refuse(errors, f"{map_path}: {error.detail}")
    except DemandProfileError as error:
        refuse(errors, str(error))
    stops = [stop.stop_id for stop in road_map.stops]
    if len(stops) < _STOPS_MIN:
        refuse(errors, f"{map_path} has {len(stops)} stops; a ride needs two")
    try:
        on = date.fromisoformat(day)
    except ValueError:
        refuse(errors, f"{day} is not a date; write it like {_DAY}")
    drawn = draw_day(profile, stops, on, ZoneInfo(road_map.timezone), rides, seed)
    try:
        write_rides(out, drawn)
    except OSError as error:
        refuse(errors, f"{out}: {error.strerror}")
    cancelled = sum(ride.cancelled_at is not None for ride in drawn)
    Console().print(
        f"{len(drawn)} rides of {on:%A %d %B %Y}, {cancelled} of them cancelled: {out}",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )
