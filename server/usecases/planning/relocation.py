"""Moves idle shuttles to where riders are expected, learned from the requests of the past weeks."""

from dataclasses import dataclass
from datetime import date, datetime, timedelta

import numpy as np

from contract.geometry import Array
from server.dispatch.demand import FREE_DAY, WORKDAY, DemandWeights, Pickup, learned_rates
from server.dispatch.waiting_places import best_move
from server.domain.fleet.battery import is_measured
from server.domain.fleet.vehicles import Vehicle
from server.domain.orders.orders import OrderState
from server.domain.planning.plans import Plan, next_version
from server.domain.service.service import ServiceCalendar
from server.usecases.orders import orders, sections
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import whole_calendar
from server.usecases.record.server_events import THE_SERVER, record_event
from server.usecases.roads.resting import rest_visit
from server.usecases.roads.section_reservations import SectionReservations

_SATURDAY = 5


@dataclass(frozen=True, slots=True)
class Demand:
    """Expected pickups at the stops of one map, learned in one hour of one day.

    rates  (2, 24, stops) pickups an hour, by kind of day
    """

    map_version: str
    hour: datetime
    rates: Array


def is_stale(uow: UnitOfWork, demand: Demand) -> bool:
    """Another hour has begun, or another map is active, since it was learned."""
    return (demand.map_version, demand.hour) != (uow.network().map_version, _hour(uow.now))


def learn_demand(uow: UnitOfWork) -> Demand:
    """Expected pickups, learned from every requested ride of the past weeks. Reads only."""
    rules, roads, calendar = uow.rules, uow.roads(), whole_calendar(uow)
    today = calendar.day_of(uow.now)
    since = uow.now - timedelta(days=rules.demand_days)
    pickups = []
    for stop_id, earliest in uow.views.pickups(since, uow.now):
        number = roads.stop_numbers.get(stop_id)
        if number is not None:
            local = earliest.astimezone(calendar.zone)
            pickups.append(Pickup(number, local.date(), local.hour))
    weights = DemandWeights(rules.demand_half_life_days, rules.demand_prior_days)
    rates = learned_rates(pickups, today, lambda day: _kind(calendar, day), len(roads.stop_ids), weights)
    return Demand(uow.network().map_version, _hour(uow.now), rates)


@dataclass(frozen=True, slots=True)
class Relocation:
    """An idle vehicle, the place that it should wait at, and the plan that this was found for."""

    vehicle_id: str
    place_id: str
    plan_version: int
    gain_s: float


def best_relocation(uow: UnitOfWork, demand: Demand) -> Relocation | None:
    """The move that lowers the expected wait most, if it lowers it enough. Reads only.

    One at a time: while a vehicle is moving, no other one sets out.
    """
    plans = {plan.vehicle_id: plan for plan in uow.plans.all()}
    if not uow.rules.relocates or any(_is_relocating(plan) for plan in plans.values()):
        return None
    rates = _expected(uow, demand)
    if float(rates.sum()) < uow.rules.relocation_pickups_1ph_min:
        return None
    places = uow.network().road_map.resting_places
    numbers = {place.place_id: number for number, place in enumerate(places)}
    idle = [v for v in uow.vehicles.all() if v.vehicle_id in plans and _is_idle(uow, v, plans[v.vehicle_id])]
    if not idle:
        return None
    at = [numbers[plans[vehicle.vehicle_id].resting_place_id] for vehicle in idle]
    free = [numbers[place_id] for place_id in _free_places(uow, SectionReservations(uow))]
    ways_s = np.array([uow.roads().times_from_rest(place) for place in places])
    move = best_move(at, free, ways_s, rates, uow.rules.relocation_gain_s_min)
    if move is None:
        return None
    plan = plans[idle[move.vehicle].vehicle_id]
    return Relocation(plan.vehicle_id, places[move.place].place_id, plan.version, move.gain_s)


def relocate(uow: UnitOfWork, move: Relocation) -> bool:
    """Send the vehicle there if its plan is unchanged and the route is safe. Returns whether it goes."""
    vehicle, plan = uow.vehicles.get(move.vehicle_id), uow.plans.get(move.vehicle_id)
    if vehicle is None or plan is None or plan.version != move.plan_version:
        return False
    reservations = SectionReservations(uow)
    if not _is_idle(uow, vehicle, plan) or move.place_id not in _free_places(uow, reservations):
        return False
    place = uow.network().resting_places[move.place_id]
    after = next_version(plan, (rest_visit(uow, place.lane_id, place.s_m, "demand"),), place.place_id)
    uow.plans.save(after, plan.version)
    if orders.reissue(uow, vehicle.vehicle_id, reservations) is None:
        # It keeps its own place, and the next period tries again.
        uow.plans.save(next_version(after, (), plan.resting_place_id), after.version)
        return False
    sections.grant_ahead(uow, reservations)
    detail = f"to {move.place_id}: {move.gain_s:.0f} s less to wait"
    record_event(uow, "vehicle.relocated", vehicle.vehicle_id, THE_SERVER, detail)
    uow.publish(topics.vehicle(uow.campus_id, vehicle.vehicle_id))
    return True


# ---------------------------------------------------------------- inside


def _kind(calendar: ServiceCalendar, day: date) -> int:
    is_free = day.weekday() >= _SATURDAY or calendar.holiday(day) is not None
    return FREE_DAY if is_free else WORKDAY


def _hour(moment: datetime) -> datetime:
    return moment.replace(minute=0, second=0, microsecond=0)


def _expected(uow: UnitOfWork, demand: Demand) -> Array:
    """(stops,) pickups an hour at the time when a shuttle that sets out now has arrived."""
    calendar = whole_calendar(uow)
    then = (uow.now + timedelta(seconds=uow.rules.relocation_ahead_s)).astimezone(calendar.zone)
    rates: Array = demand.rates[_kind(calendar, then.date()), then.hour]
    return rates


def _is_relocating(plan: Plan) -> bool:
    return any(visit.why == "demand" for visit in plan.visits)


def _is_idle(uow: UnitOfWork, vehicle: Vehicle, plan: Plan) -> bool:
    """It rests without a task, and with enough charge to take rides after the move."""
    if not vehicle.accepts_rides or vehicle.charging or plan.visits or not plan.resting_place_id:
        return False
    if plan.resting_place_id not in uow.network().resting_places:
        return False
    order = uow.orders.current(vehicle.vehicle_id)
    if order is not None and order.state is not OrderState.DONE:
        return False
    where = uow.vehicles.whereabouts(vehicle.vehicle_id)
    if where is None or where.status is None:
        return False
    ratio = where.status.battery_ratio
    return not is_measured(ratio) or ratio >= uow.rules.battery_accept_ratio


def _free_places(uow: UnitOfWork, reservations: SectionReservations) -> list[str]:
    """Resting places that are neither reserved nor occupied."""
    network = uow.network()
    reserved = {plan.resting_place_id for plan in uow.plans.all()}
    occupied = reservations.held_by_others("")
    return [
        place.place_id
        for place in network.road_map.resting_places
        if place.place_id not in reserved
        and network.section_at(place.lane_id, place.s_m).section_id not in occupied
    ]
