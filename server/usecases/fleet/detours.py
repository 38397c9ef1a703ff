"""Plans after a road was closed: unreachable calls leave them, and all riders aboard get a drop-off."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from contract.geometry import Array
from server.dispatch.problem import Call
from server.domain.errors import DestinationRefused, NoRestingPlaceFree
from server.domain.planning.plans import Plan, PlannedVisit, next_version
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import (
    WAITING,
    Ride,
    RideState,
    redirected,
)
from server.domain.roads.closures import Closure
from server.domain.service.timetable import missed, without_vehicle
from server.usecases.fleet.cut_off_calls import cut_off_calls, way_out_s, without_riders
from server.usecases.planning import plans, unreachable_rides
from server.usecases.planning.snapshot import take_snapshot
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import THE_SERVER, record_event
from server.usecases.rides import destinations


def reroute_vehicles(uow: UnitOfWork, standing: Sequence[Closure]) -> tuple[str, ...]:
    """Give every vehicle whose plan has unreachable calls a plan that it can drive. Returns their ids.

    Rides that wait there lose their vehicle. Riders aboard are let out at another stop.
    """
    snapshot = take_snapshot(uow)
    turned = []
    for vehicle in snapshot.problem.vehicles:
        lost = cut_off_calls(snapshot.problem, vehicle)
        if lost:
            row = way_out_s(snapshot.problem, vehicle)
            _reroute(uow, vehicle.vehicle_id, row, lost, unreachable_rides.names_of(standing))
            turned.append(vehicle.vehicle_id)
    return tuple(turned)


def _reroute(uow: UnitOfWork, vehicle_id: str, row: Array, lost: Sequence[Call], cause: str) -> None:
    plan = plans.plan_of(uow, vehicle_id)
    rides = _riders(uow, lost)
    exits = {ride.ride_id: _nearest(uow, ride, row) for ride in rides if ride.state is RideState.ABOARD}
    held_in = {ride_id for ride_id, to_stop in exits.items() if to_stop is None}
    # A party that cannot be let out anywhere keeps a visit.
    gone = {call.call_id for call in lost if held_in.isdisjoint(call.alight)}
    gone |= _departures_given_up(uow, plan, [visit for visit in plan.visits if visit.visit_id in gone], cause)
    waiting = {ride.ride_id for ride in rides if ride.state in WAITING}
    if gone or waiting:
        kept = [visit for visit in plan.visits if visit.visit_id not in gone]
        uow.plans.save(next_version(plan, without_riders(kept, waiting)), plan.version)
        _record_detour(
            uow, vehicle_id, [visit.stop_id for visit in plan.visits if visit.visit_id in gone], cause
        )
    plans.requeue(uow, vehicle_id, sorted(waiting))
    aboard = [ride for ride in rides if ride.ride_id in exits]
    let_out_first = [ride for ride in aboard if _let_out(uow, ride, exits[ride.ride_id], cause)]
    replan(uow, vehicle_id, rest_anew=bool(let_out_first))


def _riders(uow: UnitOfWork, calls: Sequence[Call]) -> list[Ride]:
    ride_ids = sorted({ride_id for call in calls for ride_id in (*call.board, *call.alight)})
    return [ride for ride_id in ride_ids if (ride := uow.rides.get(ride_id)) is not None]


def replan(uow: UnitOfWork, vehicle_id: str, *, rest_anew: bool = False) -> None:
    """As `plans.replan`; an incident opens if closed roads cut the shuttle off from every resting place.

    rest_anew  the plan was changed here, and its rest is to lie behind its stops
    """
    try:
        plans.replan(uow, vehicle_id)
        if rest_anew:
            plans.choose_resting_place(uow, vehicle_id)
    except NoRestingPlaceFree as error:
        open_incident(uow, IncidentKind.NO_RESTING_PLACE, vehicle_id, error.detail, vehicle_id=vehicle_id)
    else:
        clear_incident(uow, IncidentKind.NO_RESTING_PLACE, vehicle_id)


# ---------------------------------------------------------------- riders aboard


def _let_out(uow: UnitOfWork, ride: Ride, to_stop: str | None, cause: str) -> bool:
    """Let a party out at the reachable stop nearest to its destination.

    If there is no such stop, it stays on board, and an incident opens. Returns whether its exit was put in
    front of all other visits, because no plan keeps every promise.
    """
    name = f"ride {ride.ride_code} is aboard {ride.vehicle_id}"
    if to_stop is None:
        _report(uow, ride, f"{name}, which no road leads out of: {cause}")
        return False
    try:
        changed = destinations.let_out_elsewhere(uow, ride, to_stop)
    except DestinationRefused:
        changed = None
    if changed is None:
        _let_out_first(uow, ride, to_stop)
    if to_stop != ride.to_stop:
        _report(uow, ride, f"{name} and is let out at {to_stop} instead of {ride.to_stop}: {cause}")
        detail = f"{ride.to_stop} to {to_stop}: {cause}"
        record_event(uow, "ride.destination_changed", ride.ride_id, THE_SERVER, detail)
        uow.publish(topics.ride(uow.campus_id, ride.ride_id), to_stop=to_stop)
    return changed is None


def _nearest(uow: UnitOfWork, ride: Ride, row: Array) -> str | None:
    """The reachable stop with the shortest straight distance to the destination."""
    roads = uow.roads()
    there = roads.network.stops[ride.to_stop]
    x_m, y_m, _ = roads.network.pose(there.lane_id, there.s_m)

    def away_m(stop_id: str) -> tuple[float, str]:
        return roads.network.apart_m(stop_id, x_m, y_m), stop_id

    reached = [stop_id for stop_id, time_s in zip(roads.stop_ids, row, strict=True) if np.isfinite(time_s)]
    return min(reached, key=away_m, default=None)


def _let_out_first(uow: UnitOfWork, ride: Ride, to_stop: str) -> None:
    """Let the party out before all other visits. Riders who wait for the vehicle get new promises."""
    uow.rides.save(replace(redirected(ride, to_stop), let_out=ride.let_out))
    plan = plans.plan_of(uow, ride.vehicle_id or "")
    stop = uow.network().stops[to_stop]
    exit_visit = PlannedVisit(
        uow.ids.new_id("visit"),
        "stop",
        to_stop,
        stop.lane_id,
        stop.s_m,
        alight=(ride.ride_id,),
        dwell_s=uow.rules.dwell_s,
    )
    begun = [visit for visit in plan.visits if visit.state == "under_way"]
    others = [visit for visit in plan.visits if visit.state != "under_way"]
    uow.plans.save(next_version(plan, (*begun, exit_visit, *others)), plan.version)


def _report(uow: UnitOfWork, ride: Ride, cause: str) -> None:
    open_incident(
        uow,
        IncidentKind.ROAD_CLOSED,
        ride.ride_id,
        cause,
        vehicle_id=ride.vehicle_id,
        ride_id=ride.ride_id,
    )


# ---------------------------------------------------------------- departures


def _departures_given_up(uow: UnitOfWork, plan: Plan, lost: Sequence[PlannedVisit], cause: str) -> set[str]:
    """The visits that leave the plan with these calls.

    A departure that has not begun gets another vehicle. One that has begun goes on with the calls that are
    left; it is missed if its last call is cut off.
    """
    gone: set[str] = set()
    for departure_id in dict.fromkeys(visit.departure_id for visit in lost if visit.departure_id):
        departure = uow.departures.get(departure_id)
        mine = [visit for visit in plan.visits if visit.departure_id == departure_id]
        if departure is None:
            continue
        if any(visit.call == 0 and visit.state == "pending" for visit in mine):
            uow.departures.save(without_vehicle(departure))
            gone |= {visit.visit_id for visit in mine}
        elif any(visit.call == len(departure.calls) - 1 for visit in lost):
            uow.departures.save(missed(departure, cause))
            open_incident(
                uow,
                IncidentKind.DEPARTURE_MISSED,
                departure_id,
                f"{departure_id}: its end is cut off: {cause}",
            )
    return gone


def _record_detour(uow: UnitOfWork, vehicle_id: str, stop_ids: Sequence[str], cause: str) -> None:
    detail = f"{', '.join(stop_ids)}: {cause}"
    record_event(uow, "plan.turned_away", vehicle_id, "", detail)
