"""Timetable departures: mandatory, timed visits that come in through the same plans as rides."""

from server.domain.timetable import Departure
from server.usecases.ports import UnitOfWork


def plan_departures(uow: UnitOfWork) -> tuple[Departure, ...]:
    """Enter the active timetable's departures that begin soon and give each a vehicle; those assigned now.

    A departure that nobody can make within its tolerance is retried until its first call is past, then
    missed, which is an incident.
    """
    raise NotImplementedError
