"""Turns a decided route into a vehicle's plan and the expected times of its riders."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timedelta

from contract.roads.model import RestingPlace
from server.dispatch.problem import Call, CallTime, VehicleRoute
from server.domain.orders.orders import OrderState
from server.domain.planning.plans import (
    Plan,
    PlannedVisit,
    RestReason,
    next_version,
)
from server.domain.rides.rides import (
    Ride,
    RideState,
    assigned,
    unassigned,
)
from server.domain.service.timetable import given_to
from server.usecases.orders import orders
from server.usecases.planning.snapshot import Snapshot, moment
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.roads.resting import rest_visit, resting_place_for, rests_at

# Expected times are published again when they have moved by this much.
_NEWS_S = 10.0


def differs_from_plan(plan: Plan, route: VehicleRoute) -> bool:
    """The route differs from the plan in its stops, their order or their riders."""
    stops = [(v.visit_id, v.board, v.alight) for v in plan.visits if v.kind == "stop"]
    return [(c.call_id, c.board, c.alight) for c in route.calls] != stops


def save_route(uow: UnitOfWork, snapshot: Snapshot, route: VehicleRoute) -> Plan:
    """Store the route as the vehicle's next plan, ending at a resting place, and assign its riders.

    Raises PlanChanged, NoRestingPlaceFree.
    """
    plan = snapshot.plans[route.vehicle_id]
    visits = tuple(
        _visit(uow, snapshot, plan, call, time) for call, time in zip(route.calls, route.times, strict=True)
    )
    after = _with_rest(uow, snapshot, plan, visits)
    uow.plans.save(after, plan.version)
    orders.visits_removed(uow, plan, after)
    snapshot.plans[route.vehicle_id] = after
    _assign(uow, snapshot, route)
    _give_departures(uow, snapshot, route)
    uow.publish(topics.vehicle(uow.campus_id, route.vehicle_id), plan_version=after.version)
    return after


def refresh_times(uow: UnitOfWork, snapshot: Snapshot, route: VehicleRoute) -> None:
    """Expected times of a route that is the plan already; the plan keeps its version."""
    plan = snapshot.plans[route.vehicle_id]
    etas = {call.call_id: time.arrive_s for call, time in zip(route.calls, route.times, strict=True)}
    visits = tuple(
        replace(visit, eta=moment(etas[visit.visit_id])) if visit.visit_id in etas else visit
        for visit in plan.visits
    )
    if any(_differs(old, new) for old, new in zip(plan.visits, visits, strict=True)):
        uow.plans.save(replace(plan, visits=visits), plan.version)
        _assign(uow, snapshot, route)


def _visit(uow: UnitOfWork, snapshot: Snapshot, plan: Plan, call: Call, time: CallTime) -> PlannedVisit:
    known = plan.visit(call.call_id) if call.call_id else None
    visit = known or _new_visit(uow, snapshot, call)
    not_before = visit.not_before
    if not visit.departure_id:
        not_before = None
        if call.board:
            opens_s = max(snapshot.problem.requests[ride_id].pickup_from_s for ride_id in call.board)
            not_before = moment(opens_s + call.dwell_s)
    return replace(
        visit,
        board=call.board,
        alight=call.alight,
        dwell_s=call.dwell_s,
        not_before=not_before,
        eta=moment(time.arrive_s),
    )


def _new_visit(uow: UnitOfWork, snapshot: Snapshot, call: Call) -> PlannedVisit:
    roads = uow.roads()
    stop = roads.network.stops[roads.stop_ids[call.place]]
    visit = PlannedVisit(uow.ids.new_id("visit"), "stop", stop.stop_id, stop.lane_id, stop.s_m)
    chained = snapshot.chained.get(call.call_id)
    if chained is None:
        return visit
    departure, number = chained
    return replace(
        visit,
        departure_id=departure.departure_id,
        call=number,
        not_before=departure.calls[number].leave_at,
        latest=moment(call.arrive_by_s),
    )


def _with_rest(uow: UnitOfWork, snapshot: Snapshot, plan: Plan, visits: tuple[PlannedVisit, ...]) -> Plan:
    """The plan with its rest visit behind the first stops; without one if the vehicle rests there already.

    A shuttle at rest that was ordered away for a ride that has ended is ordered to stay.
    """
    here = snapshot.positions[plan.vehicle_id]
    place_here = (here.lane_id, here.s_m)
    resting = tuple(visit for visit in plan.visits if visit.kind == "rest")
    arriving = tuple(visit for visit in resting if visit.state == "under_way")
    charges = plan.vehicle_id in snapshot.charging
    standing = rests_at(uow, plan, place_here)
    if charges and standing is not None and standing not in uow.network().road_map.charging_places:
        standing = None
    if not visits and standing is not None:
        stay = () if arriving or not _is_ordered_away(uow, plan) else (rest_visit(uow, *place_here),)
        return next_version(plan, (*arriving, *stay), standing.place_id)
    # One that was ordered away would drive on to its first stop, however long before its time.
    is_held_back = standing is not None and not _is_ordered_away(uow, plan)
    count = _stops_ahead(uow, snapshot, plan, visits, is_held_back)
    if count == 0 and standing is not None:
        return next_version(plan, (*arriving, rest_visit(uow, *place_here), *visits), standing.place_id)
    place, _ = _rest_after(uow, snapshot, plan, visits, count)
    same = [v for v in resting if (v.lane_id, v.s_m) == (place.lane_id, place.s_m) and v not in arriving]
    why: RestReason = "charge" if charges else ""
    rest = replace(same[0], why=why) if same else rest_visit(uow, place.lane_id, place.s_m, why)
    return next_version(plan, (*arriving, *visits[:count], rest, *visits[count:]), place.place_id)


def _is_ordered_away(uow: UnitOfWork, plan: Plan) -> bool:
    order = uow.orders.current(plan.vehicle_id)
    return order is not None and order.state is not OrderState.DONE


def _stops_ahead(
    uow: UnitOfWork, snapshot: Snapshot, plan: Plan, visits: tuple[PlannedVisit, ...], is_held_back: bool
) -> int:
    """How many stops the next order contains: none if the shuttle can rest before the first one is due.

    A shuttle that waits at a stop before its time blocks the road for those behind it. A party that gets off
    at a stop does not wait for those who board there.

    is_held_back  the shuttle rests, and gets its order when it is time for the first stop (`orders.reissue`)
    """
    most = min(len(visits), uow.rules.order_stops)
    for number, visit in enumerate(visits[:most]):
        starts = number == 0 and (is_held_back or visit.state == "under_way")
        if starts or visit.alight or visit.not_before is None or visit.eta is None:
            continue
        idle_s = (visit.not_before - visit.eta).total_seconds() - visit.dwell_s
        early_s = uow.rules.early_s(timed=bool(visit.departure_id))
        if idle_s <= early_s:
            continue
        begun = uow.now if number == 0 else _left_at(visits[number - 1])
        free_s = (visit.not_before - begun).total_seconds() - visit.dwell_s - early_s
        _, way_s = _rest_after(uow, snapshot, plan, visits, number)
        if way_s * uow.travel_time_factor_at(begun) <= free_s:
            return number
    return most


def _left_at(visit: PlannedVisit) -> datetime:
    """The planned departure from a visit."""
    if visit.eta is None:
        raise ValueError(f"visit {visit.visit_id} has no expected time")
    leaves = visit.eta + timedelta(seconds=visit.dwell_s)
    return leaves if visit.not_before is None else max(leaves, visit.not_before)


def _rest_after(
    uow: UnitOfWork, snapshot: Snapshot, plan: Plan, visits: tuple[PlannedVisit, ...], count: int
) -> tuple[RestingPlace, float]:
    """The resting place behind the first `count` stops, and the seconds by way of it to the next stop."""
    here = snapshot.positions[plan.vehicle_id]
    last = (visits[count - 1].lane_id, visits[count - 1].s_m) if count else (here.lane_id, here.s_m)
    onward = visits[count] if count < len(visits) else None
    charges = onward is None and plan.vehicle_id in snapshot.charging
    return resting_place_for(uow, plan, last, onward, snapshot.reservations, charges=charges)


def _assign(uow: UnitOfWork, snapshot: Snapshot, route: VehicleRoute) -> None:
    pickups: dict[str, float] = {}
    arrivals: dict[str, float] = {}
    for call, time in zip(route.calls, route.times, strict=True):
        for ride_id in call.board:
            opens_s = snapshot.problem.requests[ride_id].pickup_from_s
            pickups[ride_id] = max(time.arrive_s, opens_s)
        for ride_id in call.alight:
            arrivals[ride_id] = time.arrive_s
    for ride_id, arrival_s in arrivals.items():
        before = snapshot.rides[ride_id]
        after = _with_times(before, route.vehicle_id, pickups.get(ride_id), arrival_s)
        if after != before:
            uow.rides.save(after)
            snapshot.rides[ride_id] = after
            uow.publish(topics.ride(uow.campus_id, ride_id), vehicle_id=route.vehicle_id)


def _with_times(ride: Ride, vehicle_id: str, pickup_s: float | None, arrival_s: float) -> Ride:
    pickup_eta = ride.pickup_eta if pickup_s is None else moment(pickup_s)
    arrival_eta = moment(arrival_s)
    if ride.vehicle_id != vehicle_id and ride.state is not RideState.ABOARD and pickup_eta is not None:
        free = ride if ride.state is RideState.REQUESTED else unassigned(ride)
        return assigned(free, vehicle_id, pickup_eta, arrival_eta)
    return replace(ride, pickup_eta=pickup_eta, arrival_eta=arrival_eta)


def _give_departures(uow: UnitOfWork, snapshot: Snapshot, route: VehicleRoute) -> None:
    given: dict[str, None] = dict.fromkeys(
        snapshot.chained[call.call_id][0].departure_id
        for call in route.calls
        if call.call_id in snapshot.chained
    )
    for departure_id in given:
        departure = uow.departures.get(departure_id)
        if departure is not None:
            uow.departures.save(given_to(departure, route.vehicle_id))


def _differs(old: PlannedVisit, new: PlannedVisit) -> bool:
    if old.eta is None or new.eta is None:
        return old.eta is not new.eta
    return abs((new.eta - old.eta).total_seconds()) >= _NEWS_S


def vehicles_with_ride(plans: Sequence[Plan], ride_id: str) -> list[str]:
    """The vehicles whose plans name this ride."""
    return [plan.vehicle_id for plan in plans if ride_id in plan.ride_ids]
