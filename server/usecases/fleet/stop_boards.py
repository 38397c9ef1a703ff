"""What a screen at a stop shows: departures and shuttles that come. It names no rider."""

from dataclasses import dataclass
from datetime import datetime, timedelta

from server.domain.errors import StopUnknown
from server.domain.fleet.vehicles import Vehicle
from server.domain.planning.eta_ranges import ExpectedRange, PlannedPickup, pickup_range
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.roads.stops import CampusStop
from server.domain.service.announcements import Announcement
from server.domain.service.timetable import Departure, DepartureState
from server.travel.closed_roads import sections_of
from server.usecases.fleet import announcements, campus
from server.usecases.planning.outlooks import seats_left_at
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import calendars

# What fits on a screen that is read from some metres away.
ROWS_MAX = 8
# A departure that could not be made is shown for so long after its time.
MISSED_FOR_S = 600.0
# A closure is announced so long before it begins.
CLOSURES_AHEAD_S = 6 * 3600.0
CLOSURES_MAX = 3


@dataclass(frozen=True, slots=True)
class BoardDeparture:
    """A trip of the timetable that leaves this stop.

    to_stop  where the trip ends
    expected  when the shuttle leaves, None while no shuttle or no time is known
    """

    trip_id: str
    leave_at: datetime
    to_stop: str
    state: DepartureState
    vehicle_name: str
    expected: ExpectedRange | None
    is_here: bool
    is_last: bool
    seats_left: int | None


@dataclass(frozen=True, slots=True)
class BoardShuttle:
    """A shuttle that comes for riders who booked.

    expected  None while its time cannot be told: it stands, or is out of reach
    """

    vehicle_name: str
    expected: ExpectedRange | None
    is_here: bool
    seats_left: int | None


@dataclass(frozen=True, slots=True)
class BoardClosure:
    """A closed road that concerns the stop, now or in the next hours.

    is_served  shuttles reach the stop all the same
    """

    reason: str
    starts_at: datetime
    ends_at: datetime | None
    is_served: bool


@dataclass(frozen=True, slots=True)
class StopBoard:
    """holiday: the name of today's, None on an ordinary day; opens_next None: not for weeks."""

    stop: CampusStop
    timezone: str
    now: datetime
    departures: tuple[BoardDeparture, ...]
    shuttles: tuple[BoardShuttle, ...]
    open_now: bool
    opens_next: datetime | None
    closes_at: datetime | None
    holiday: str | None
    closures: tuple[BoardClosure, ...] = ()
    announcements: tuple[Announcement, ...] = ()


@dataclass(frozen=True, slots=True)
class _Coming:
    """A visit of a plan at this stop, and how many stops its shuttle makes before."""

    vehicle: Vehicle
    visit: PlannedVisit
    stops_before: int
    seats_left: int | None

    @property
    def is_here(self) -> bool:
        return self.visit.state == "under_way"


def stop_board(uow: UnitOfWork, stop_id: str) -> StopBoard:
    """Raises StopUnknown, CampusUnknown."""
    calendar = calendars.calendar_of(uow)
    today = calendars.service_day(uow)
    coming = _coming(uow, stop_id)
    return StopBoard(
        stop=stop_of(uow, stop_id),
        timezone=uow.network().road_map.timezone,
        now=uow.now,
        departures=_departures(uow, stop_id, today.last_calls.get(stop_id), coming)[:ROWS_MAX],
        shuttles=_shuttles(uow, coming)[:ROWS_MAX],
        open_now=calendar.is_open(uow.now),
        opens_next=calendar.next_opening(uow.now),
        closes_at=calendar.closes_after(uow.now),
        holiday=None if today.holiday is None else today.holiday.note,
        closures=_closures(uow, stop_id),
        announcements=tuple(one for one in announcements.current(uow) if one.is_at_stop(stop_id)),
    )


def stop_of(uow: UnitOfWork, stop_id: str) -> CampusStop:
    """Raises StopUnknown, CampusUnknown."""
    stop = next((stop for stop in campus.stops(uow) if stop.stop_id == stop_id), None)
    if stop is None:
        raise StopUnknown(f"the map has no stop {stop_id!r}; see /api/v1/stops")
    return stop


def _closures(uow: UnitOfWork, stop_id: str) -> tuple[BoardClosure, ...]:
    """Those on the stop's own lane, and those that keep every shuttle from the stop; by their beginning."""
    roads = uow.roads().every_road
    lane_id = roads.network.stops[stop_id].lane_id
    here = {section.section_id for section in roads.network.sections_of(lane_id)}
    until = uow.now + timedelta(seconds=CLOSURES_AHEAD_S)
    found = []
    for closure in uow.closures.standing() if uow.has_closures() else ():
        closed = frozenset(sections_of(closure, roads.network))
        is_served = roads.closed_to(closed).serves(stop_id)
        if closure.starts_at <= until and (not is_served or not here.isdisjoint(closed)):
            found.append(BoardClosure(closure.reason, closure.starts_at, closure.ends_at, is_served))
    return tuple(sorted(found, key=lambda one: one.starts_at)[:CLOSURES_MAX])


def _coming(uow: UnitOfWork, stop_id: str) -> tuple[_Coming, ...]:
    plans = {plan.vehicle_id: plan for plan in uow.plans.all()}
    found = []
    for vehicle in uow.vehicles.all():
        plan = plans.get(vehicle.vehicle_id)
        if plan is not None and any(visit.stop_id == stop_id for visit in plan.visits):
            found += _of_plan(uow, vehicle, plan, stop_id)
    return tuple(found)


def _of_plan(uow: UnitOfWork, vehicle: Vehicle, plan: Plan, stop_id: str) -> list[_Coming]:
    stops = [visit for visit in plan.visits if visit.kind == "stop" and visit.is_open]
    free = seats_left_at(uow, vehicle, plan)
    return [
        _Coming(vehicle, visit, number, free.get(visit.visit_id))
        for number, visit in enumerate(stops)
        if visit.stop_id == stop_id
    ]


def _departures(
    uow: UnitOfWork, stop_id: str, last_call: datetime | None, coming: tuple[_Coming, ...]
) -> tuple[BoardDeparture, ...]:
    """Of today and of yesterday's night, by time. One that has left is not shown."""
    yesterday = calendars.calendar_of(uow).day_of(uow.now) - timedelta(days=1)
    days = (calendars.service_day(uow, yesterday), calendars.service_day(uow))
    rows = [
        row
        for day in days
        for departure in day.departures
        for number, call in enumerate(departure.calls[:-1])
        if call.stop_id == stop_id
        if (row := _departure(uow, departure, number, last_call, coming)) is not None
    ]
    return tuple(sorted(rows, key=lambda row: (row.leave_at, row.trip_id)))


def _departure(
    uow: UnitOfWork,
    departure: Departure,
    number: int,
    last_call: datetime | None,
    coming: tuple[_Coming, ...],
) -> BoardDeparture | None:
    call = departure.calls[number]
    served = next(
        (
            one
            for one in coming
            if one.visit.departure_id == departure.departure_id and one.visit.call == number
        ),
        None,
    )
    is_over = call.leave_at + timedelta(seconds=MISSED_FOR_S) < uow.now
    has_left = served is None and departure.state in (DepartureState.ASSIGNED, DepartureState.DONE)
    if departure.state is DepartureState.WITHDRAWN or has_left or (served is None and is_over):
        return None
    return BoardDeparture(
        trip_id=departure.trip_id,
        leave_at=call.leave_at,
        to_stop=departure.calls[-1].stop_id,
        state=departure.state,
        vehicle_name="" if served is None else served.vehicle.name,
        expected=None if served is None else _expected(uow, served, call.leave_at),
        is_here=served is not None and served.is_here,
        is_last=call.leave_at == last_call,
        seats_left=None if served is None else served.seats_left,
    )


def _shuttles(uow: UnitOfWork, coming: tuple[_Coming, ...]) -> tuple[BoardShuttle, ...]:
    rows = [
        BoardShuttle(
            one.vehicle.name,
            _expected(uow, one, one.visit.not_before or uow.now),
            one.is_here,
            one.seats_left,
        )
        for one in coming
        if not one.visit.departure_id
    ]
    last = uow.now + timedelta(days=1)
    return tuple(
        sorted(
            rows,
            key=lambda row: (not row.is_here, last if row.expected is None else row.expected.earliest),
        )
    )


def _expected(uow: UnitOfWork, one: _Coming, opens: datetime) -> ExpectedRange | None:
    """None for a shuttle that stands at the stop, that is held, or out of reach."""
    if one.is_here or one.visit.eta is None or not one.vehicle.connected or one.vehicle.held:
        return None
    return pickup_range(uow.now, PlannedPickup(max(one.visit.eta, opens), opens, one.stops_before))
