"""How the fleet is assigned: every change of a vehicle's plan goes through this page.

A decision takes a snapshot of the fleet, solves it, and stores the changed routes by compare and set. The
changed vehicles get new orders as soon as their new routes are safe.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from math import isfinite

from server.dispatch.problem import Problem, VehicleState
from server.dispatch.refusal import CLOSED
from server.dispatch.solve import Budget, Solution, solve
from server.domain.errors import (
    NoRestingPlaceFree,
    StopUnknown,
    StopUnreachable,
    VehicleNotPlaced,
    VehicleOutOfService,
)
from server.domain.planning.plans import Plan, PlannedVisit, next_version
from server.domain.rides.rides import (
    WAITING,
    Ride,
    RideState,
    promised_anew,
    unassigned,
)
from server.domain.service.timetable import Departure, without_vehicle
from server.usecases.orders import orders
from server.usecases.planning import promises, unreachable_rides
from server.usecases.planning.assign import assign_rides
from server.usecases.planning.decisions import SearchSettings, keep_improvement
from server.usecases.planning.issue_orders import adopt_routes, issue_orders
from server.usecases.planning.routes import differs_from_plan, refresh_times, save_route
from server.usecases.planning.snapshot import Snapshot, take_snapshot
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.failed_rides import fail_late_ride
from server.usecases.record.server_events import record_event

_INSERT_ONLY = Budget()


def plan_of(uow: UnitOfWork, vehicle_id: str) -> Plan:
    """Raises VehicleUnknown."""
    plan = uow.plans.get(vehicle_id)
    if plan is not None:
        return plan
    enrolled_vehicle(uow, vehicle_id)
    return Plan(uow.campus_id, vehicle_id, 0)


def insert_departures(uow: UnitOfWork, departures: Sequence[Departure]) -> frozenset[str]:
    """Give each departure a vehicle that can make it. Returns the ids of those that got one."""
    snapshot = take_snapshot(uow, departures=departures)
    solution = _solve_insertions(snapshot)
    adopt_routes(uow, snapshot, solution.routes)
    return frozenset(d.departure_id for d in departures) - solution.refused.keys()


def replan(uow: UnitOfWork, vehicle_id: str) -> None:
    """Make a vehicle's plan fit what has happened: ended rides leave it, riders aboard get a drop-off."""
    snapshot = take_snapshot(uow)
    if vehicle_id not in snapshot.positions:
        return
    solution = _solve_insertions(snapshot)
    if vehicle_id in solution.impossible:
        release_waiting(uow, vehicle_id)
        snapshot = take_snapshot(uow)
        solution = _solve_insertions(snapshot)
    mine = tuple(route for route in solution.routes if route.vehicle_id == vehicle_id)
    adopt_routes(uow, snapshot, mine)


def assign_waiting(uow: UnitOfWork, also: Sequence[Ride] = ()) -> tuple[Ride, ...]:
    """Give every ride that has lost its vehicle to another one. Returns the rides that got one.

    also  assigned rides whose vehicle cannot come in time: another vehicle that keeps the promise gets them
    If no vehicle can keep a promise, the ride gets the earliest possible pickup instead. A ride that no
    vehicle could take within the longest wait fails, with an incident. So does a ride that a closed road
    cuts off, unless the road opens in time (`unreachable_rides`).
    """
    wanted = [*uow.rides.in_states([RideState.REQUESTED]), *_rides_of_unavailable_vehicles(uow), *also]
    waiting = list({ride.ride_id: ride for ride in wanted}.values())
    if not waiting:
        return ()
    free = [as_new_request(uow, ride, in_time=True) for ride in waiting]
    answers = assign_rides(uow, free, "reassignment")
    found = [answer.ride for answer in answers if not answer.rule]
    left = [
        (ride, request)
        for ride, request, answer in zip(waiting, free, answers, strict=True)
        if answer.rule and (ride.state is RideState.REQUESTED or _promise_has_lapsed(uow, ride))
    ]
    cut_off_rides: list[Ride] = []
    late = [as_new_request(uow, ride, in_time=False) for ride, _ in left]
    for (ride, _), answer in zip(left, assign_rides(uow, late, "reassignment"), strict=True):
        if not answer.rule:
            found.append(save_late_promise(uow, ride, answer.ride))
        elif ride.state is RideState.REQUESTED and answer.rule == CLOSED and uow.roads().closed:
            cut_off_rides.append(ride)
        elif ride.state is RideState.REQUESTED:
            fail_late_ride(uow, ride, answer.rule)
    unreachable_rides.postpone(uow, cut_off_rides)
    return tuple(found)


def as_new_request(uow: UnitOfWork, ride: Ride, *, in_time: bool) -> Ride:
    """A waiting ride as a request for another vehicle. in_time: with its promise."""
    free = ride if ride.state is RideState.REQUESTED else unassigned(ride)
    return free if in_time else replace(free, promise=None, requested_at=uow.now, arrive_before=None)


def save_late_promise(uow: UnitOfWork, ride: Ride, taken: Ride) -> Ride:
    """Save a ride that another vehicle took without regard to its promise, and publish the new promise."""
    kept = _with_late_promise(ride, taken)
    uow.rides.save(kept)
    if kept.promise_broken:
        promises.publish_broken_promise(uow, kept, "goes with another shuttle, later than promised")
    return kept


def release_waiting(uow: UnitOfWork, vehicle_id: str) -> None:
    """Take its waiting rides from a vehicle; `assign_waiting` finds them another one."""
    waiting = uow.rides.of_vehicle(vehicle_id, sorted(WAITING))
    requeue(uow, vehicle_id, [ride.ride_id for ride in waiting])


def requeue(uow: UnitOfWork, vehicle_id: str, ride_ids: Sequence[str]) -> None:
    """Make rides that a vehicle will not pick up wait for another one."""
    for ride_id in ride_ids:
        ride = uow.rides.get(ride_id)
        if ride is not None and ride.vehicle_id == vehicle_id and ride.state in WAITING:
            uow.rides.save(unassigned(ride))
            uow.publish(topics.ride(uow.campus_id, ride_id))
            uow.publish(topics.dispatch(uow.campus_id))


def release_departures(uow: UnitOfWork, vehicle_id: str, call_ids: frozenset[str] | None = None) -> None:
    """Take the departures from a vehicle that it has not begun; it finishes the others.

    call_ids  only departures that have one of these visits as a call
    """
    plan = uow.plans.get(vehicle_id)
    if plan is None:
        return
    begun = {visit.departure_id for visit in plan.visits if visit.call > 0} - {
        visit.departure_id for visit in plan.visits if visit.departure_id and visit.call == 0
    }
    if call_ids is not None:
        named = {visit.departure_id for visit in plan.visits if visit.visit_id in call_ids}
        begun |= {visit.departure_id for visit in plan.visits} - named
    kept = [visit for visit in plan.visits if not visit.departure_id or visit.departure_id in begun]
    if len(kept) == len(plan.visits):
        return
    after = next_version(plan, kept)
    uow.plans.save(after, plan.version)
    orders.visits_removed(uow, plan, after)
    for departure in uow.departures.unfinished():
        if departure.vehicle_id == vehicle_id and departure.departure_id not in begun:
            uow.departures.save(without_vehicle(departure))


def overdue(uow: UnitOfWork) -> frozenset[str]:
    """Rides, and visits of departures, that the present plans serve too late."""
    return _solve_insertions(take_snapshot(uow)).overdue


def send_to_stop(uow: UnitOfWork, vehicle_id: str, stop_id: str, by: str) -> Plan:
    """Send a vehicle to a stop after everything that it has already promised (developer, operator).

    Raises VehicleUnknown, VehicleNotPlaced, VehicleOutOfService, StopUnknown, StopUnreachable.
    """
    plan = plan_of(uow, vehicle_id)
    vehicle = uow.vehicles.get(vehicle_id)
    roads = uow.roads()
    stop = roads.network.stops.get(stop_id)
    if stop is None:
        raise StopUnknown(f"the map has no stop {stop_id}")
    if vehicle is None or not vehicle.placed:
        raise VehicleNotPlaced(f"the position of {vehicle_id} is not known; place it first")
    if not vehicle.in_service:
        raise VehicleOutOfService(f"{vehicle_id} has been recalled; return it to service first")
    snapshot = take_snapshot(uow)
    state = next((v for v in snapshot.problem.vehicles if v.vehicle_id == vehicle_id), None)
    place = roads.stop_numbers[stop_id]
    if state is None or not isfinite(_from_its_last_call_s(snapshot.problem, state, place)):
        raise StopUnreachable(f"no road leads {vehicle_id} to stop {stop.name}")
    visit = PlannedVisit(
        uow.ids.new_id("visit"), "stop", stop_id, stop.lane_id, stop.s_m, dwell_s=uow.rules.dwell_s
    )
    stops = tuple(v for v in plan.visits if v.kind == "stop" or v.state == "under_way")
    rests = tuple(v for v in plan.visits if v.kind == "rest" and v.state == "pending")
    uow.plans.save(next_version(plan, (*stops, visit, *rests)), plan.version)
    record_event(uow, "vehicle.sent", vehicle_id, by, stop_id)
    choose_resting_place(uow, vehicle_id)
    return plan_of(uow, vehicle_id)


def choose_resting_place(uow: UnitOfWork, vehicle_id: str) -> None:
    """Choose the resting place and the times of a changed plan, and reissue its order.

    Raises NoRestingPlaceFree.
    """
    snapshot = take_snapshot(uow)
    for route in _solve_insertions(snapshot).routes:
        if route.vehicle_id == vehicle_id:
            save_route(uow, snapshot, route)
    issue_orders(uow, snapshot, (vehicle_id,))


def extend_order(uow: UnitOfWork, vehicle_id: str) -> None:
    """After a stop, move the rest visit behind the next stops, so that the order goes on."""
    plan = uow.plans.get(vehicle_id)
    if plan is None:
        return
    stops = [visit for visit in plan.visits if visit.kind == "stop"]
    ordered = [visit for visit in plan.ordered if visit.kind == "stop"]
    if len(ordered) < min(len(stops), uow.rules.order_stops):
        try_planning(uow, vehicle_id, choose_resting_place)


def try_planning(uow: UnitOfWork, vehicle_id: str, make_plan: Callable[[UnitOfWork, str], None]) -> None:
    """Change a vehicle's plan. If no resting place is free for it, the plan stays, and the record says so."""
    try:
        make_plan(uow, vehicle_id)
    except NoRestingPlaceFree as error:
        record_event(uow, "plan.waits", vehicle_id, "", error.detail)


def refresh_expected(uow: UnitOfWork, snapshot: Snapshot | None = None) -> None:
    """Update expected times to the present positions of the vehicles.

    snapshot  one of this transaction, if there is one that still holds
    """
    snapshot = snapshot or take_snapshot(uow)
    for route in _solve_insertions(snapshot).routes:
        if not differs_from_plan(snapshot.plans[route.vehicle_id], route):
            refresh_times(uow, snapshot, route)


# ---------------------------------------------------------------- improvement


@dataclass(frozen=True, slots=True)
class Improvement:
    """A problem to be improved outside a transaction, and the plans that it was made from."""

    problem: Problem
    plans: dict[str, Plan]

    def is_changed_by(self, solution: Solution) -> bool:
        """Whether the solution differs from the plans."""
        return any(differs_from_plan(self.plans[route.vehicle_id], route) for route in solution.routes)


def improvement_of(snapshot: Snapshot) -> Improvement | None:
    """The fleet, if something can be moved: two waiting rides, or one ride and two vehicles."""
    accepting = sum(vehicle.accepts for vehicle in snapshot.problem.vehicles)
    waiting = sum(len(call.board) for vehicle in snapshot.problem.vehicles for call in vehicle.calls)
    if waiting == 0 or waiting + accepting < 3:
        return None
    return Improvement(snapshot.problem, dict(snapshot.plans))


def adopt_improvement(
    uow: UnitOfWork, improvement: Improvement, solution: Solution, search: SearchSettings
) -> tuple[str, ...]:
    """Store the improved routes if no plan has changed meanwhile, all of them or none.

    Returns the vehicles whose plans changed. A late answer is dropped.
    """
    snapshot = take_snapshot(uow)
    if _versions(snapshot.plans) != _versions(improvement.plans):
        return ()
    before = dict(snapshot.rides)
    changed = adopt_routes(uow, snapshot, solution.routes)
    if changed:
        keep_improvement(uow, improvement.problem, search, solution, before)
    return changed


# ---------------------------------------------------------------- inside


def _from_its_last_call_s(problem: Problem, vehicle: VehicleState, place: int) -> float:
    row = problem.times[vehicle.calls[-1].place] if vehicle.calls else vehicle.to_places_s
    return float(row[place])


def _versions(plans: Mapping[str, Plan]) -> dict[str, int]:
    return {vehicle_id: plan.version for vehicle_id, plan in plans.items()}


def _solve_insertions(snapshot: Snapshot) -> Solution:
    # Without improvement nothing is drawn, so that the seed does not matter.
    return solve(snapshot.problem, _INSERT_ONLY, 0)


def _promise_has_lapsed(uow: UnitOfWork, ride: Ride) -> bool:
    """The promise cannot be kept: the vehicle that comes first is better than further waiting."""
    return ride.promise is not None and (ride.promise_broken or uow.now > ride.promise.pickup_to)


def _with_late_promise(ride: Ride, taken: Ride) -> Ride:
    """A ride that another vehicle has taken over, its old promise kept beside the new one."""
    kept = replace(taken, requested_at=ride.requested_at, arrive_before=ride.arrive_before)
    if ride.promise is None or taken.promise is None:
        return kept
    before = replace(kept, promise=ride.promise, first_promise=ride.first_promise)
    return promised_anew(before, taken.promise)


def _rides_of_unavailable_vehicles(uow: UnitOfWork) -> list[Ride]:
    """Rides that wait for a vehicle which has been unavailable for too long."""
    limit = uow.now - timedelta(seconds=uow.rules.reassign_after_s)
    return [
        ride
        for vehicle in uow.vehicles.all()
        if vehicle.unavailable_since is not None
        and vehicle.unavailable_since <= limit
        # A timed hold gives its late rides away when it begins.
        and (vehicle.hold_ends is None or vehicle.hold_ends <= uow.now)
        for ride in uow.rides.of_vehicle(vehicle.vehicle_id, [RideState.ASSIGNED])
    ]
