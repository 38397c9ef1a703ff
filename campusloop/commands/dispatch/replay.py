"""`campusloop dispatch replay`: repeat a day's decisions and compare them bit for bit."""

from datetime import datetime
from typing import Annotated
from zoneinfo import ZoneInfo

import typer
from rich.console import Console
from rich.progress import track

from campusloop.commands.dispatch.explain import DatabaseUrl
from campusloop.commands.dispatch.output import JsonPath, refuse, write_json
from campusloop.studies.dispatch.decision_replay import RepeatedDecision, repeat_all
from campusloop.studies.dispatch.stored_campus import StoredCampusError, local_day, stored_campus

_DIFFERENT = 1


def replay(
    day: Annotated[str, typer.Argument(metavar="DAY", help="YYYY-MM-DD, in the campus's time zone")],
    database: DatabaseUrl = None,
    json_path: JsonPath = None,
) -> None:
    """Repeat every stored decision of a day; exit 1 if any differs."""
    errors = Console(stderr=True)
    try:
        with stored_campus(database) as uow:
            zone = ZoneInfo(uow.network().road_map.timezone)
            decisions = uow.decisions.between(*local_day(uow, day))
    except StoredCampusError as error:
        refuse(errors, str(error))
    if not decisions:
        refuse(errors, f"no decision of {day} is stored; the history is kept for a month")
    repeated = list(
        track(
            repeat_all(decisions),
            "repeating",
            total=len(decisions),
            console=errors,
            transient=True,
        )
    )
    different = [decision for decision in repeated if not decision.equal]
    if json_path is None or not write_json(errors, json_path, _report(day, repeated)):
        _print_result(Console(), day, repeated, different, zone)
    if different:
        raise typer.Exit(_DIFFERENT)


def _print_result(
    console: Console,
    day: str,
    repeated: list[RepeatedDecision],
    different: list[RepeatedDecision],
    zone: ZoneInfo,
) -> None:
    kinds = dict.fromkeys(one.decision.kind for one in repeated)
    counts = ", ".join(f"{sum(one.decision.kind == kind for one in repeated)} {kind}" for kind in kinds)
    equal = len(repeated) - len(different)
    console.print(
        f"{equal} of {len(repeated)} decisions of {day} are the same, bit for bit ({counts}).",
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


def _report(day: str, repeated: list[RepeatedDecision]) -> dict[str, object]:
    return {
        "day": day,
        "decisions": len(repeated),
        "equal": sum(one.equal for one in repeated),
        "different": [
            {
                "decision_id": one.decision.decision_id,
                "made_at": one.decision.made_at.isoformat(),
                "kind": one.decision.kind,
                "difference": one.difference,
            }
            for one in repeated
            if not one.equal
        ],
    }
