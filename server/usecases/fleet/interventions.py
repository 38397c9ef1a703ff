"""Operators' interventions with a vehicle, and their effects on all riders.

An intervention returns its effects. In a transaction that is rolled back it is its own preview: the effects
are the same if nothing changes in between.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import timedelta

from server.domain.errors import (
    ReassignmentRefused,
    RideAlreadyAboard,
    RideEnded,
    RideNotAssigned,
    RideUnknown,
)
from server.domain.fleet.vehicles import Vehicle, VehicleCommand
from server.domain.rides.effects import Effects, Intervention
from server.domain.rides.rides import Ride, RideState
from server.usecases.fleet import departures
from server.usecases.fleet.conditions import with_availability
from server.usecases.fleet.vehicles import recall
from server.usecases.planning import plans
from server.usecases.planning.assign import assign_rides
from server.usecases.planning.effects import effects_since, observe_fleet
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.commands import send_command
from server.usecases.record.enrolled_vehicles import active_vehicle, enrolled_vehicle
from server.usecases.record.refusals import REFUSAL_TEXTS
from server.usecases.record.server_events import THE_SERVER, record_event


@dataclass(frozen=True, slots=True)
class InterventionResult:
    """command: sent to the vehicle, if the intervention needs one."""

    effects: Effects
    command: VehicleCommand | None = None


def intervene(uow: UnitOfWork, vehicle_id: str, intervention: Intervention, by: str) -> InterventionResult:
    """Carry out an intervention. Returns its effects.

    Raises VehicleUnknown; for a reassignment also RideUnknown, RideNotAssigned, RideAlreadyAboard, RideEnded,
    ReassignmentRefused, NoRestingPlaceFree.
    """
    fleet = observe_fleet(uow)
    stood = enrolled_vehicle(uow, vehicle_id).held
    command = None
    match intervention.kind:
        case "hold":
            command = hold(uow, vehicle_id, by, intervention.for_s)
        case "recall":
            recall(uow, vehicle_id, by)
        case "reassign":
            reassign(uow, vehicle_id, by, intervention.ride_id, intervention.to_vehicle_id)
    after = enrolled_vehicle(uow, vehicle_id)
    stands = after.held and after.hold_ends is None and not stood
    return InterventionResult(effects_since(uow, fleet, vehicle_id if stands else ""), command)


def hold(uow: UnitOfWork, vehicle_id: str, by: str, for_s: float | None = None) -> VehicleCommand:
    """Bring a vehicle to a comfortable stand, for `for_s` seconds or until it is resumed.

    A timed hold reassigns its late rides when it begins. A hold without an end reassigns every waiting ride
    whose promise another vehicle can keep, and the departures. A vehicle that already stands for another
    reason is not resumed by the clock. Raises VehicleUnknown.
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    is_by_clock = for_s is not None and (not vehicle.held or vehicle.hold_ends is not None)
    ends = uow.now + timedelta(seconds=for_s) if for_s is not None and is_by_clock else None
    command = send_command(uow, vehicle_id, "hold", by)
    uow.vehicles.save(with_availability(uow, replace(vehicle, held=True, hold_ends=ends)))
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id))
    waiting = uow.rides.of_vehicle(vehicle_id, [RideState.ASSIGNED])
    if ends is None:
        plans.release_departures(uow, vehicle_id)
    else:
        late = plans.overdue(uow)
        plans.release_departures(uow, vehicle_id, late)
        waiting = tuple(ride for ride in waiting if ride.ride_id in late)
    plans.replan(uow, vehicle_id)
    plans.assign_waiting(uow, waiting)
    departures.assign_planned(uow)
    return command


def end_holds(uow: UnitOfWork) -> tuple[str, ...]:
    """Resume the vehicles whose hold is over. Returns their ids.

    A vehicle that is out of reach, or stands for another reason by now, waits for an operator.
    """
    ended = []
    for vehicle in uow.vehicles.all():
        if vehicle.hold_ends is None or vehicle.hold_ends > uow.now:
            continue
        uow.vehicles.save(replace(vehicle, hold_ends=None))
        if vehicle.connected and vehicle.mode == "held":
            send_command(uow, vehicle.vehicle_id, "resume", THE_SERVER)
            ended.append(vehicle.vehicle_id)
        uow.publish(topics.vehicle(uow.campus_id, vehicle.vehicle_id))
    return tuple(ended)


def reassign(uow: UnitOfWork, vehicle_id: str, by: str, ride_id: str = "", to_vehicle_id: str = "") -> None:
    """Give one waiting ride of a vehicle, or all of them, to a named vehicle or to any other.

    If the new vehicle cannot keep the promise, the party gets a new one. No improvement takes the rides
    back. If all rides are given away, those that no other vehicle can take stay; a single ride is refused
    then.

    Raises VehicleUnknown, RideUnknown, RideNotAssigned, RideAlreadyAboard, RideEnded, ReassignmentRefused,
    NoRestingPlaceFree.
    """
    enrolled_vehicle(uow, vehicle_id)
    others = {v.vehicle_id for v in uow.vehicles.all()} - {vehicle_id}
    if to_vehicle_id:
        others = {_other(uow, vehicle_id, to_vehicle_id).vehicle_id}
    if ride_id:
        waiting: Sequence[Ride] = [_waiting_ride(uow, vehicle_id, ride_id)]
    else:
        waiting = uow.rides.of_vehicle(vehicle_id, [RideState.ASSIGNED])
    rules = _give_rides(uow, waiting, others)
    if ride_id and rules:
        rule = rules[ride_id]
        whom = to_vehicle_id or "another shuttle"
        raise ReassignmentRefused(
            f"the ride cannot be given to {whom}: {REFUSAL_TEXTS.get(rule, rule)}", rule
        )
    detail = f"{ride_id or len(waiting)} to {to_vehicle_id or 'any other'}"
    record_event(uow, "vehicle.reassigned", vehicle_id, by, detail)


# ---------------------------------------------------------------- inside


def _other(uow: UnitOfWork, vehicle_id: str, to_vehicle_id: str) -> Vehicle:
    if to_vehicle_id == vehicle_id:
        raise ReassignmentRefused(f"{vehicle_id} has the ride already; name another vehicle")
    vehicle = active_vehicle(uow, to_vehicle_id)
    return vehicle


def _waiting_ride(uow: UnitOfWork, vehicle_id: str, ride_id: str) -> Ride:
    ride = uow.rides.get(ride_id)
    if ride is None:
        raise RideUnknown(f"there is no ride {ride_id}")
    if ride.has_ended:
        raise RideEnded(f"ride {ride.ride_code} is {ride.state} already")
    if ride.state is RideState.ABOARD:
        raise RideAlreadyAboard(f"ride {ride.ride_code} sits in {ride.vehicle_id} already")
    if ride.state is not RideState.ASSIGNED or ride.vehicle_id != vehicle_id:
        raise RideNotAssigned(f"ride {ride.ride_code} does not wait for {vehicle_id}")
    return ride


def _give_rides(uow: UnitOfWork, waiting: Sequence[Ride], to: set[str]) -> dict[str, str]:
    """Give the rides to these vehicles, in time if possible. Returns the rules for those they cannot take."""
    left = _try_to_give(uow, waiting, to, in_time=True)
    return _try_to_give(uow, [ride for ride in waiting if ride.ride_id in left], to, in_time=False)


def _try_to_give(uow: UnitOfWork, waiting: Sequence[Ride], to: set[str], *, in_time: bool) -> dict[str, str]:
    free = [plans.as_new_request(uow, ride, in_time=in_time) for ride in waiting]
    left: dict[str, str] = {}
    for ride, answer in zip(waiting, assign_rides(uow, free, "reassignment", to), strict=True):
        if answer.rule:
            left[ride.ride_id] = answer.rule
            continue
        taken = answer.ride if in_time else plans.save_late_promise(uow, ride, answer.ride)
        uow.rides.save(replace(taken, pinned=True))
    return left
