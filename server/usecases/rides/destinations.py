"""Another destination for a ride that waits or is under way, and getting off as soon as possible.

No other promise changes: a change is inserted like a booking, or refused with the rule that binds.
"""

import math
from dataclasses import replace
from datetime import timedelta

import numpy as np

from server.dispatch.problem import Call, VehicleRoute, VehicleState
from server.dispatch.refusal import CLOSED
from server.domain.errors import (
    DestinationRefused,
    NoRestingPlaceFree,
    NoService,
    RideEnded,
    SameStop,
    StopUnknown,
    StopUnreachable,
)
from server.domain.rides.rides import (
    Promise,
    Ride,
    RideState,
    redirected,
    unassigned,
)
from server.usecases.planning.assign import assign_ride
from server.usecases.planning.issue_orders import adopt_routes
from server.usecases.planning.snapshot import (
    Snapshot,
    moment,
    seconds,
    take_snapshot,
)
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.calendars import calendar_of
from server.usecases.record.refusals import REFUSAL_TEXTS, closing_text
from server.usecases.record.server_events import record_event
from server.usecases.rides.drop_offs import cheapest_with_drop_off, exits


def change_destination(uow: UnitOfWork, ride: Ride, to_stop: str, by: str) -> Ride:
    """The ride to another stop, with a new latest arrival; the pickup promise stays.

    The present destination changes nothing. Raises RideEnded, StopUnknown, SameStop,
    StopUnreachable, NoService (it would end after closing), DestinationRefused (`rule` says what binds).
    """
    _require_possible(uow, ride, to_stop)
    if to_stop == ride.to_stop and not ride.let_out:
        return ride
    wanted = redirected(ride, to_stop)
    changed = _insert_into_present_vehicle(uow, wanted)
    if changed is None:
        changed = _insert_into_any_vehicle(uow, wanted)
    _require_before_closing(uow, changed)
    _record_and_publish(uow, changed, "ride.destination_changed", by, f"{ride.to_stop} to {to_stop}")
    return changed


def let_out_elsewhere(uow: UnitOfWork, ride: Ride, to_stop: str) -> Ride | None:
    """Let a party aboard out at another stop, at the least cost; None if that breaks a promise."""
    return _insert_into_present_vehicle(uow, replace(redirected(ride, to_stop), let_out=ride.let_out))


def let_out(uow: UnitOfWork, ride: Ride, by: str) -> Ride:
    """Let a party aboard out at the first stop that breaks no promise, else at the next stop of the plan.

    The ride goes on until the vehicle reports that the party is out.
    """
    snapshot = take_snapshot(uow)
    vehicle = _vehicle_of(snapshot, ride)
    stop_ids = uow.roads().stop_ids
    for place, index in exits(snapshot.problem.times, vehicle, ride.ride_id):
        wanted = replace(redirected(ride, stop_ids[place]), let_out=True)
        route = _route_with_drop_off(uow, snapshot, vehicle, wanted, index)
        if route is not None:
            changed = _adopt_route(uow, snapshot, wanted, route)
            _record_and_publish(uow, changed, "ride.let_out", by, wanted.to_stop)
            return changed
    changed = replace(ride, let_out=True)
    uow.rides.save(changed)
    _record_and_publish(uow, changed, "ride.let_out", by, ride.to_stop)
    return changed


# ---------------------------------------------------------------- checks


def _require_possible(uow: UnitOfWork, ride: Ride, to_stop: str) -> None:
    roads = uow.roads()
    if ride.has_ended:
        raise RideEnded(f"ride {ride.ride_code} is {ride.state} already")
    if to_stop not in roads.stop_numbers:
        raise StopUnknown(f"the map has no stop {to_stop}")
    if to_stop == ride.from_stop:
        if ride.state is not RideState.ABOARD:
            raise SameStop("from and to are the same stop; cancel the ride instead")
    elif math.isinf(roads.direct_s(ride.from_stop, to_stop)):
        raise StopUnreachable("no road leads there from the pickup stop")
    if roads.is_cut_off(ride.from_stop if ride.state is not RideState.ABOARD else to_stop, to_stop):
        raise DestinationRefused(f"{REFUSAL_TEXTS[CLOSED]}; your ride stays as it was", CLOSED)


def _require_before_closing(uow: UnitOfWork, ride: Ride) -> None:
    closes = ride.arrive_before
    if closes is not None and ride.arrival_eta is not None and ride.arrival_eta > closes:
        raise NoService(closing_text(calendar_of(uow), closes))


def _is_planned_for(snapshot: Snapshot, ride: Ride) -> bool:
    return any(vehicle.vehicle_id == ride.vehicle_id for vehicle in snapshot.problem.vehicles)


def _vehicle_of(snapshot: Snapshot, ride: Ride) -> VehicleState:
    for vehicle in snapshot.problem.vehicles:
        if vehicle.vehicle_id == ride.vehicle_id:
            return vehicle
    detail = "the shuttle cannot be given a new way now; press the seat button, or call for help"
    raise DestinationRefused(detail, "no_vehicle_free")


# ---------------------------------------------------------------- on another vehicle: inserted like a booking


def _insert_into_any_vehicle(uow: UnitOfWork, wanted: Ride) -> Ride:
    """Insert the ride into any vehicle. Its pickup window is kept, and it gets a new latest arrival."""
    if wanted.state in (RideState.BOARDING, RideState.ABOARD):
        raise DestinationRefused(
            "others in the shuttle, or waiting for it, could not be there in time; your ride stays as it was",
            "arrival",
        )
    free = wanted if wanted.state is RideState.REQUESTED else unassigned(wanted)
    open_ended = None
    if wanted.promise is not None:
        # The longest ride binds before this does.
        far = wanted.promise.pickup_to + timedelta(seconds=_ride_s_max(uow, wanted) + uow.rules.dwell_s)
        open_ended = replace(wanted.promise, arrive_by=far)
    try:
        answer = assign_ride(uow, replace(free, promise=open_ended), "change")
    except NoRestingPlaceFree as error:
        raise DestinationRefused(error.detail, "no_vehicle_free") from error
    if answer.rule:
        raise DestinationRefused(f"{REFUSAL_TEXTS[answer.rule]}; your ride stays as it was", answer.rule)
    return _with_new_arrival(uow, answer.ride)


def _ride_s_max(uow: UnitOfWork, ride: Ride) -> float:
    direct_s = uow.roads().direct_s(ride.from_stop, ride.to_stop)
    return uow.rules.ride_s_max(direct_s * uow.travel_time_factor_at(max(uow.now, ride.earliest)))


# ---------------------------------------------------------------- on the vehicle that has it


def _insert_into_present_vehicle(uow: UnitOfWork, wanted: Ride) -> Ride | None:
    """Let the party out with its present vehicle, whose way to the pickup stays; None if that fails."""
    if wanted.vehicle_id is None:
        return None
    snapshot = take_snapshot(uow)
    if wanted.state is RideState.ASSIGNED and not _is_planned_for(snapshot, wanted):
        return None
    vehicle = _vehicle_of(snapshot, wanted)
    place = uow.roads().stop_numbers[wanted.to_stop]
    if not np.isfinite([*snapshot.problem.times[:, place], vehicle.to_places_s[place]]).any():
        raise StopUnreachable("no road leads the shuttle to that stop")
    route = _route_with_drop_off(uow, snapshot, vehicle, wanted)
    return None if route is None else _adopt_route(uow, snapshot, wanted, route)


def _route_with_drop_off(
    uow: UnitOfWork,
    snapshot: Snapshot,
    vehicle: VehicleState,
    wanted: Ride,
    only_before: int | None = None,
) -> VehicleRoute | None:
    """The vehicle's cheapest route to the new destination, as `cheapest_with_drop_off`."""
    place = uow.roads().stop_numbers[wanted.to_stop]
    request = snapshot.problem.requests[wanted.ride_id]
    longest_s = math.inf if wanted.state is RideState.ABOARD else _ride_s_max(uow, wanted)
    patient = replace(request, dropoff=place, arrive_by_s=math.inf, ride_s_max=longest_s)
    factor = uow.travel_time_factor_at(uow.now)
    out = Call(place, (), (wanted.ride_id,), uow.rules.dwell_s, travel_time_factor=factor)
    return cheapest_with_drop_off(snapshot.problem, vehicle, patient, out, only_before)


def _adopt_route(uow: UnitOfWork, snapshot: Snapshot, wanted: Ride, route: VehicleRoute) -> Ride:
    uow.rides.save(wanted)
    snapshot.rides[wanted.ride_id] = wanted
    try:
        adopt_routes(uow, snapshot, (route,))
    except NoRestingPlaceFree as error:
        raise DestinationRefused(error.detail, "no_vehicle_free") from error
    return _with_new_arrival(uow, snapshot.rides[wanted.ride_id])


def _with_new_arrival(uow: UnitOfWork, ride: Ride) -> Ride:
    """The latest arrival after the one planned now, with the slack of a booking."""
    if ride.promise is None or ride.arrival_eta is None:
        uow.rides.save(ride)
        return ride
    begun = uow.now if ride.boarded_at is not None or ride.pickup_eta is None else ride.pickup_eta
    terms = uow.roads().promise_rules(uow.rules)
    arrive_by = moment(terms.arrive_by_s(seconds(begun), seconds(ride.arrival_eta), seconds(uow.now)))
    promised = replace(ride, promise=Promise(ride.promise.pickup_from, ride.promise.pickup_to, arrive_by))
    uow.rides.save(promised)
    return promised


def _record_and_publish(uow: UnitOfWork, ride: Ride, name: str, by: str, detail: str) -> None:
    record_event(uow, name, ride.ride_id, by, detail)
    uow.publish(topics.ride(uow.campus_id, ride.ride_id), to_stop=ride.to_stop)
