"""`campusloop dispatch explain`: why a ride got its shuttle, or none."""

from typing import Annotated, Any

import msgspec
import typer
from rich.console import Console

from campusloop.commands.dispatch.ending import JsonPath, refuse, write_json
from campusloop.studies.dispatch.explanation import Decided, Explainer
from campusloop.studies.dispatch.stored_campus import CampusUnread, stored_campus
from server.domain.rides.rides import Ride
from server.usecases.ports.unit_of_work import UnitOfWork

DatabaseUrl = Annotated[
    str | None,
    typer.Option("--database", metavar="URL", help="the server's database, if it is not the one set here"),
]


def explain(
    ride: Annotated[str, typer.Argument(metavar="RIDE", help="a ride's code, as said aloud, or its id")],
    database: DatabaseUrl = None,
    json_path: JsonPath = None,
) -> None:
    """Say in plain words what was decided about a ride, and why."""
    errors = Console(stderr=True)
    try:
        with stored_campus(database) as uow:
            found = _ride(uow, ride)
            if found is None:
                refuse(
                    errors,
                    f"no ride has the code or id {ride}; codes have six characters and are on the "
                    "passenger's phone, ids are in the console's list of rides",
                )
            decided = [
                Decided(one, uow.decisions.get(one.decision_id))
                for one in uow.decisions.of_ride(found.ride_id)
            ]
            names = {vehicle.vehicle_id: vehicle.name for vehicle in uow.vehicles.all()}
            explainer = Explainer(uow.network().road_map, names)
    except CampusUnread as error:
        refuse(errors, str(error))
    lines = explainer.lines(found, decided)
    if json_path is None or not write_json(errors, json_path, _report(found, decided, lines)):
        Console().print("\n".join(lines), markup=False, highlight=False, soft_wrap=True)


def _ride(uow: UnitOfWork, named: str) -> Ride | None:
    """Codes are read without regard to case and spaces."""
    return uow.rides.get(named.strip()) or uow.rides.by_code("".join(named.split()).upper())


def _report(ride: Ride, decided: list[Decided], lines: list[str]) -> dict[str, Any]:
    """Without the passenger's secrets: neither the link's token nor the boarding code."""
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
        "decisions": [{"kind": one.kind} | _decision(one) for one in decided],
        "words": lines,
    }


def _decision(decided: Decided) -> dict[str, Any]:
    plain: dict[str, Any] = msgspec.to_builtins(decided.about)
    return {name: value for name, value in plain.items() if name not in ("campus_id", "ride_id")}
