"""`campusloop dispatch explain`: why a ride was given to its shuttle, or was refused."""

from typing import Annotated, Any

import msgspec
import typer
from rich.console import Console

from campusloop.commands.dispatch.output import JsonPath, refuse, write_json
from campusloop.studies.dispatch.explanation import Explainer, StoredRideDecision
from campusloop.studies.dispatch.stored_campus import (
    StoredCampusError,
    known_databases,
    stored_campus,
)
from server.domain.rides.rides import Ride
from server.usecases.ports.unit_of_work import UnitOfWork

DatabaseUrl = Annotated[
    str | None,
    typer.Option(
        "--database",
        metavar="URL",
        help="the server's database; default: the configured one, or those of a server and a demo here",
    ),
]


def explain(
    ride: Annotated[str, typer.Argument(metavar="RIDE", help="a ride's code or its id")],
    database: DatabaseUrl = None,
    json_path: JsonPath = None,
) -> None:
    """Explain the decisions about a ride in plain text."""
    errors = Console(stderr=True)
    try:
        told = None
        for url in known_databases(database):
            with stored_campus(url) as uow:
                told = told or _explained(uow, ride)
    except StoredCampusError as error:
        refuse(errors, str(error))
    if told is None:
        refuse(
            errors,
            f"no ride has the code or id {ride}; codes have six characters and are on the "
            "passenger's phone, ids are in the console's list of rides",
        )
    found, decisions, lines = told
    if json_path is None or not write_json(errors, json_path, _report(found, decisions, lines)):
        Console().print("\n".join(lines), markup=False, highlight=False, soft_wrap=True)


def _explained(uow: UnitOfWork, ride: str) -> tuple[Ride, list[StoredRideDecision], list[str]] | None:
    """The ride, its decisions and the text; None if this database has no such ride."""
    found = _ride(uow, ride)
    if found is None:
        return None
    decisions = [
        StoredRideDecision(decision, uow.decisions.get(decision.decision_id))
        for decision in uow.decisions.of_ride(found.ride_id)
    ]
    names = {vehicle.vehicle_id: vehicle.name for vehicle in uow.vehicles.all()}
    return found, decisions, Explainer(uow.network().road_map, names).lines(found, decisions)


def _ride(uow: UnitOfWork, code_or_id: str) -> Ride | None:
    """Case and spaces of a code are ignored."""
    return uow.rides.get(code_or_id.strip()) or uow.rides.by_code("".join(code_or_id.split()).upper())


def _report(ride: Ride, decisions: list[StoredRideDecision], lines: list[str]) -> dict[str, Any]:
    """Without the passenger's secrets: the link's token and the boarding code."""
    return {
        "ride_id": ride.ride_id,
        "ride_code": ride.ride_code,
        "state": str(ride.state),
        "from_stop": ride.from_stop,
        "to_stop": ride.to_stop,
        "party": ride.party,
        "wheelchairs": ride.wheelchairs,
        "requested_at": ride.requested_at.isoformat(),
        "earliest": ride.earliest.isoformat(),
        "vehicle_id": ride.vehicle_id,
        "reason": ride.reason,
        "decisions": [{"kind": decision.kind} | _decision(decision) for decision in decisions],
        "text": lines,
    }


def _decision(decision: StoredRideDecision) -> dict[str, Any]:
    plain: dict[str, Any] = msgspec.to_builtins(decision.of_ride)
    return {name: value for name, value in plain.items() if name not in ("campus_id", "ride_id")}
