"""Timetable departures: mandatory, timed visits that come in through the same plans as rides."""

from datetime import timedelta
from zoneinfo import ZoneInfo

from server.domain.errors import NoRestingPlaceFree
from server.domain.incidents import IncidentKind
from server.domain.timetable import Departure, DepartureState, departures_of, missed
from server.usecases import plans, topics
from server.usecases.incidents import open_incident
from server.usecases.ports import UnitOfWork


def plan_departures(uow: UnitOfWork) -> tuple[Departure, ...]:
    """Enter the active timetable's departures that begin soon and give each a vehicle; those assigned now.

    A departure that nobody can make within its tolerance is retried until its first call is past, then
    missed, which is an incident.
    """
    _enter_due(uow)
    assigned = []
    for departure in uow.departures.unfinished():
        if departure.state is not DepartureState.PLANNED:
            continue
        if _insert(uow, departure):
            assigned.append(uow.departures.get(departure.departure_id) or departure)
            uow.publish(topics.dispatch(uow.campus_id), departure_id=departure.departure_id)
        else:
            _give_up_late(uow, departure)
    return tuple(assigned)


def _insert(uow: UnitOfWork, departure: Departure) -> bool:
    try:
        return bool(plans.insert_departures(uow, (departure,)))
    except NoRestingPlaceFree:
        return False


def _enter_due(uow: UnitOfWork) -> None:
    road_map = uow.network().road_map
    horizon = uow.now + timedelta(seconds=uow.rules.departure_lead_s)
    zone = ZoneInfo(road_map.timezone)
    days = dict.fromkeys((uow.now.astimezone(zone).date(), horizon.astimezone(zone).date()))
    for day in days:
        for departure in departures_of(uow.campus_id, road_map.timetable, road_map.timezone, day):
            due = uow.now <= departure.calls[0].leave_at <= horizon
            if due and uow.departures.get(departure.departure_id) is None:
                uow.departures.add(departure)


def _give_up_late(uow: UnitOfWork, departure: Departure) -> None:
    latest = departure.calls[0].leave_at + timedelta(seconds=uow.rules.departure_tolerance_s)
    if uow.now <= latest:
        return
    reason = "no shuttle could make it in time"
    uow.departures.save(missed(departure, reason))
    open_incident(
        uow, IncidentKind.DEPARTURE_MISSED, departure.departure_id, f"{departure.departure_id}: {reason}"
    )
