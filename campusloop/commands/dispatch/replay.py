"""`campusloop dispatch replay`: make a day's decisions again and compare them bit for bit."""

from datetime import datetime
from typing import Annotated
from zoneinfo import ZoneInfo

import typer
from rich.console import Console
from rich.progress import track

from campusloop.commands.dispatch.ending import JsonPath, refuse, write_json
from campusloop.commands.dispatch.explain import DatabaseUrl
from campusloop.studies.dispatch.decision_replay import RepeatedDecision, repeat_all
from campusloop.studies.dispatch.stored_campus import CampusUnread, local_day, stored_campus

_DIFFERENT = 1


def replay(
    day: Annotated[str, typer.Argument(metavar="DAY", help="YYYY-MM-DD, where the campus is")],
    database: DatabaseUrl = None,
    json_path: JsonPath = None,
) -> None:
    """Make every stored decision of a day again; exit 1 when any differs."""
    errors = Console(stderr=True)
    try:
        with stored_campus(database) as uow:
            zone = ZoneInfo(uow.network().road_map.timezone)
            decisions = uow.decisions.between(*local_day(uow, day))
    except CampusUnread as error:
        refuse(errors, str(error))
    if not decisions:
        refuse(errors, f"no decision of {day} is stored; the history is kept for a month")
    made = list(
        track(
            repeat_all(decisions),
            "repeating",
            total=len(decisions),
            console=errors,
            transient=True,
        )
    )
    different = [one for one in made if not one.equal]
    if json_path is None or not write_json(errors, json_path, _report(day, made)):
        _tell(Console(), day, made, different, zone)
    if different:
        raise typer.Exit(_DIFFERENT)


def _tell(
    console: Console,
    day: str,
    made: list[RepeatedDecision],
    different: list[RepeatedDecision],
    zone: ZoneInfo,
) -> None:
    kinds = dict.fromkeys(one.decision.kind for one in made)
    counts = ", ".join(f"{sum(one.decision.kind == kind for one in made)} {kind}" for kind in kinds)
    equal = len(made) - len(different)
    console.print(
        f"{equal} of {len(made)} decisions of {day} came out the same, bit for bit ({counts}).",
        highlight=False,
        soft_wrap=True,
    )
    if different:
        first = different[0]
        console.print(
            f"The first that differs was made at {_time(first.decision.made_at, zone)} "
            f"({first.decision.kind}, {first.decision.decision_id}): {first.difference}.",
            style="red",
            markup=False,
            highlight=False,
            soft_wrap=True,
        )


def _time(at: datetime, zone: ZoneInfo) -> str:
    return f"{at.astimezone(zone):%H:%M:%S}"


def _report(day: str, made: list[RepeatedDecision]) -> dict[str, object]:
    return {
        "day": day,
        "decisions": len(made),
        "equal": sum(one.equal for one in made),
        "different": [
            {
                "decision_id": one.decision.decision_id,
                "made_at": one.decision.made_at.isoformat(),
                "kind": one.decision.kind,
                "difference": one.difference,
            }
            for one in made
            if not one.equal
        ],
    }
