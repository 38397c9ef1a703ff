"""Records the actions of people and of the server: what was done to which ride, vehicle, map or calendar."""

from datetime import datetime

from server.domain.record.events import ServerEvent
from server.usecases.ports.unit_of_work import UnitOfWork

THE_SERVER = "server"
BRAKING_EVENT = "vehicle.braked"


def record_event(uow: UnitOfWork, name: str, subject: str, by: str, detail: str = "") -> None:
    """Append an event to the record of this transaction.

    name     `noun.verb`, e.g. `ride.cancelled`
    subject  id of the ride, vehicle, incident, map or calendar that it is about
    by       operator, vehicle or token that caused it; THE_SERVER or "" when nothing outside did
    """
    uow.events.add_server_event(ServerEvent(uow.campus_id, uow.now, name, subject, by, detail))


def record_braking(uow: UnitOfWork, vehicle_id: str, at: datetime, by: str) -> None:
    """A vehicle has braked hard at that moment. by: the guard, the planner or the driver."""
    event = ServerEvent(uow.campus_id, at, BRAKING_EVENT, vehicle_id, by, "")
    uow.events.add_server_event(event)
