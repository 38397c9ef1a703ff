"""Timetable departures: mandatory, timed visits that come in through the same plans as rides."""

from datetime import timedelta

from server.domain.errors import NoRestingPlaceFree
from server.domain.planning.plans import Plan, PlannedVisit, next_version
from server.domain.record.incidents import IncidentKind
from server.domain.service.service import ServiceCalendar
from server.domain.service.timetable import (
    Departure,
    DepartureState,
    departures_of,
    missed,
    withdrawn,
)
from server.usecases.planning import plans
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of, trips_of, trips_on, unserved_of
from server.usecases.record.incidents import clear_incident, open_incident

# The subject of the incident about trips that do not run, and how many it names.
_TIMETABLE = "timetable"
_TRIPS_NAMED = 10


def plan_departures(uow: UnitOfWork) -> tuple[Departure, ...]:
    """Enter departures that begin soon and give each one a vehicle. Returns those assigned now.

    A departure that no vehicle can make within its tolerance is retried until its first call is over. Then it
    is missed, with an incident. Trips that cannot run on the active map are told as long as they cannot.
    """
    note_unserved(uow)
    _enter_due(uow)
    return assign_planned(uow)


def note_unserved(uow: UnitOfWork) -> None:
    """Open, renew or close the incident of the trips whose stops the active map lacks."""
    unserved = unserved_of(uow)
    known = uow.incidents.open_about(IncidentKind.TRIPS_UNSERVED, _TIMETABLE)
    if not unserved:
        clear_incident(uow, IncidentKind.TRIPS_UNSERVED, _TIMETABLE)
        return
    stops = sorted({stop_id for one in unserved for stop_id in one.missing_stops})
    names = ", ".join(one.trip_id for one in unserved[:_TRIPS_NAMED])
    more = "" if len(unserved) <= _TRIPS_NAMED else f" and {len(unserved) - _TRIPS_NAMED} more"
    cause = f"{names}{more}: the map has no stop {', '.join(stops[:_TRIPS_NAMED])}"
    if known is not None and known.cause != cause:
        clear_incident(uow, IncidentKind.TRIPS_UNSERVED, _TIMETABLE)
    open_incident(uow, IncidentKind.TRIPS_UNSERVED, _TIMETABLE, cause)


def assign_planned(uow: UnitOfWork) -> tuple[Departure, ...]:
    """Give each departure without a vehicle one. Returns those assigned now."""
    assigned = []
    for departure in uow.departures.unfinished():
        if departure.state is not DepartureState.PLANNED:
            continue
        if _insert(uow, departure):
            assigned.append(uow.departures.get(departure.departure_id) or departure)
            uow.publish(topics.dispatch(uow.campus_id), departure_id=departure.departure_id)
        else:
            _miss_late_departure(uow, departure)
    return tuple(assigned)


def _insert(uow: UnitOfWork, departure: Departure) -> bool:
    try:
        return bool(plans.insert_departures(uow, (departure,)))
    except NoRestingPlaceFree:
        return False


def withdraw_unserved(uow: UnitOfWork, calendar: ServiceCalendar) -> None:
    """Withdraw the departures whose service no longer runs on their day, except those that have begun."""
    services = {trip.trip_id: trip.service_id for trip in trips_of(uow)}
    for departure in uow.departures.unfinished():
        runs = calendar.runs(services.get(departure.trip_id, ""), departure.day)
        if not runs and not _has_begun(uow, departure):
            _withdraw(uow, departure, "the service was taken off this day")


def withdraw_changed(uow: UnitOfWork) -> tuple[tuple[Departure, ...], tuple[Departure, ...]]:
    """Withdraw the departures that the timetable no longer has, or has at other times.

    Returns them as they were, and those that have begun and therefore run on.
    """
    trips = {trip.trip_id: trip for trip in trips_of(uow)}
    timezone = uow.network().road_map.timezone
    withdrawn_ones, kept = [], []
    for departure in uow.departures.unfinished():
        trip = trips.get(departure.trip_id)
        made = () if trip is None else departures_of(uow.campus_id, (trip,), timezone, departure.day)
        if made and made[0].calls == departure.calls:
            continue
        if _has_begun(uow, departure):
            kept.append(departure)
        else:
            _withdraw(uow, departure, "the timetable was changed")
            withdrawn_ones.append(departure)
    return tuple(withdrawn_ones), tuple(kept)


def _has_begun(uow: UnitOfWork, departure: Departure) -> bool:
    if departure.vehicle_id is None:
        return False
    plan = uow.plans.get(departure.vehicle_id)
    first = None if plan is None else _first_call(plan, departure.departure_id)
    return first is None or first.state != "pending"


def _first_call(plan: Plan, departure_id: str) -> PlannedVisit | None:
    return next((v for v in plan.visits if v.departure_id == departure_id and v.call == 0), None)


def _withdraw(uow: UnitOfWork, departure: Departure, reason: str) -> None:
    uow.departures.save(withdrawn(departure, reason))
    plan = None if departure.vehicle_id is None else uow.plans.get(departure.vehicle_id)
    if plan is None:
        return
    kept = [visit for visit in plan.visits if visit.departure_id != departure.departure_id]
    uow.plans.save(next_version(plan, kept), plan.version)
    plans.replan(uow, plan.vehicle_id)


def _enter_due(uow: UnitOfWork) -> None:
    road_map = uow.network().road_map
    if not trips_of(uow):
        return
    calendar = calendar_of(uow)
    horizon = uow.now + timedelta(seconds=uow.rules.departure_lead_s)
    # A trip past 24:00 belongs to the day before.
    first, last = calendar.day_of(uow.now) - timedelta(days=1), calendar.day_of(horizon)
    for offset in range((last - first).days + 1):
        day = first + timedelta(days=offset)
        trips = trips_on(uow, calendar, day)
        for departure in departures_of(uow.campus_id, trips, road_map.timezone, day):
            due = uow.now <= departure.calls[0].leave_at <= horizon
            known = uow.departures.get(departure.departure_id) if due else None
            if due and known is None:
                uow.departures.add(departure)
            elif known is not None and known.state is DepartureState.WITHDRAWN:
                uow.departures.save(departure)


def _miss_late_departure(uow: UnitOfWork, departure: Departure) -> None:
    latest = departure.calls[0].leave_at + timedelta(seconds=uow.rules.departure_tolerance_s)
    if uow.now <= latest:
        return
    reason = "no shuttle could make it in time"
    uow.departures.save(missed(departure, reason))
    open_incident(
        uow, IncidentKind.DEPARTURE_MISSED, departure.departure_id, f"{departure.departure_id}: {reason}"
    )
