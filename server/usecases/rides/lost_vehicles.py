"""Riders aboard a shuttle that cannot go on: another one picks them up at the nearest stop.

A shuttle is lost when it has stood with a fault for long, when an operator says so, or when it is taken off
the road. A shuttle that is only silent may still be driving: its riders stay with it until an operator
decides.
"""

import math
from dataclasses import replace
from datetime import timedelta

from contract.wire.messages import DriveMode
from server.domain.errors import NobodyAboard
from server.domain.fleet.vehicles import Vehicle
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import (
    Ride,
    RideState,
    boarded,
    ended,
    stranded,
)
from server.travel.walking import on_foot_s
from server.usecases.planning import plans
from server.usecases.planning.routes import vehicles_with_ride
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.failed_rides import fail_ride
from server.usecases.record.incidents import open_incident
from server.usecases.record.server_events import record_event

LOST_MODES: tuple[DriveMode, ...] = ("minimal_risk", "fault")
# A party within this distance of the destination has arrived.
_THERE_M = 30.0


def rescue_riders(uow: UnitOfWork) -> tuple[Ride, ...]:
    """Send the riders of shuttles that have stood with a fault for too long to stops near by."""
    limit = uow.now - timedelta(seconds=uow.rules.reassign_after_s)
    moved: list[Ride] = []
    for vehicle in uow.vehicles.all():
        since = vehicle.unavailable_since
        if vehicle.mode in LOST_MODES and since is not None and since <= limit:
            moved += strand_riders(uow, vehicle, f"{vehicle.vehicle_id} stands ({vehicle.mode})")
    return tuple(moved)


def evacuate(uow: UnitOfWork, vehicle_id: str, by: str) -> tuple[Ride, ...]:
    """An operator decides that a shuttle cannot go on: its riders go on with others.

    Returns their rides as they are now. Raises VehicleUnknown, NobodyAboard.
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    record_event(uow, "vehicle.evacuated", vehicle_id, by, "")
    concerned = strand_riders(uow, vehicle, f"an operator has {vehicle_id} evacuated")
    if not concerned:
        raise NobodyAboard(f"no rider is aboard {vehicle_id}")
    plans.assign_waiting(uow)
    return tuple(uow.rides.get(ride.ride_id) or ride for ride in concerned)


def strand_riders(uow: UnitOfWork, vehicle: Vehicle, cause: str) -> list[Ride]:
    """Send all riders aboard to the nearest stop, to wait for another shuttle. Each ride is an incident.

    If the position is not known, or if the nearest stop is their destination, the ride ends.
    `plans.assign_waiting` finds the other shuttle. Returns all of these rides.
    """
    aboard = uow.rides.of_vehicle(vehicle.vehicle_id, [RideState.ABOARD])
    concerned = [_strand(uow, ride, cause) for ride in aboard]
    if concerned and not vehicle.retired:
        # One lost shuttle without a resting place does not keep the riders of others waiting.
        plans.try_planning(uow, vehicle.vehicle_id, plans.replan)
        uow.publish(topics.dispatch(uow.campus_id))
    return concerned


def _strand(uow: UnitOfWork, ride: Ride, cause: str) -> Ride:
    nearest = _nearest_stop(uow, ride)
    if nearest is None:
        return _fail_lost_ride(uow, ride, f"{cause}, and its position is not known")
    stop_id, walk_s = nearest
    if stop_id == ride.to_stop:
        return _fail_lost_ride(uow, ride, f"{cause}; your stop is {_minutes(walk_s)} away on foot")
    after = stranded(ride, stop_id, uow.now + timedelta(seconds=walk_s), uow.now)
    uow.rides.save(after)
    stop = uow.network().stops[stop_id].name
    _record_stranded(uow, ride, f"{cause}; another shuttle comes to {stop}, {_minutes(walk_s)} on foot")
    return after


def rider_left_lost_vehicle(uow: UnitOfWork, vehicle_id: str, ride: Ride) -> None:
    """The lost shuttle reports that a stranded party has got off."""
    if not _is_near(uow, vehicle_id, ride.to_stop):
        record_event(uow, "ride.left_lost_vehicle", ride.ride_id, vehicle_id, "")
        return
    aboard = replace(boarded(ride, ride.boarded_how or "tap", uow.now), vehicle_id=vehicle_id)
    uow.rides.save(ended(aboard, RideState.COMPLETED, uow.now))
    record_event(uow, "ride.completed", ride.ride_id, vehicle_id, "with the shuttle that was given up")
    uow.publish(topics.ride(uow.campus_id, ride.ride_id))
    for other in vehicles_with_ride(uow.plans.all(), ride.ride_id):
        plans.replan(uow, other)


def _nearest_stop(uow: UnitOfWork, ride: Ride) -> tuple[str, float] | None:
    """The nearest stop from which the ride can go on, or its destination, and the seconds there on foot.

    None if the shuttle's position is not known.
    """
    where = uow.vehicles.whereabouts(ride.vehicle_id or "")
    if where is None or where.status is None:
        return None
    roads, pose = uow.roads(), where.status.pose_map
    stop_ids = [
        stop.stop_id
        for stop in roads.network.road_map.stops
        if stop.stop_id == ride.to_stop or math.isfinite(roads.direct_s(stop.stop_id, ride.to_stop))
    ]
    apart_m = {stop_id: roads.network.apart_m(stop_id, pose.x_m, pose.y_m) for stop_id in stop_ids}
    nearest = min(stop_ids, key=apart_m.__getitem__)
    return nearest, on_foot_s(apart_m[nearest], uow.rules.walk_mps)


def _minutes(walk_s: float) -> str:
    count = max(1, round(walk_s / 60.0))
    return "1 minute" if count == 1 else f"{count} minutes"


def _is_near(uow: UnitOfWork, vehicle_id: str, stop_id: str) -> bool:
    where = uow.vehicles.whereabouts(vehicle_id)
    if where is None or where.status is None:
        return False
    pose = where.status.pose_map
    return uow.network().apart_m(stop_id, pose.x_m, pose.y_m) <= _THERE_M


def _fail_lost_ride(uow: UnitOfWork, ride: Ride, detail: str) -> Ride:
    fail_ride(uow, ride, "vehicle_lost", detail, f"{detail}; make sure that the party gets on")
    record_event(uow, "ride.failed", ride.ride_id, "", detail)
    return uow.rides.get(ride.ride_id) or ride


def _record_stranded(uow: UnitOfWork, ride: Ride, detail: str) -> None:
    open_incident(
        uow,
        IncidentKind.PROMISE_BROKEN,
        ride.ride_id,
        f"ride {ride.ride_code}: {detail}",
        vehicle_id=ride.vehicle_id,
        ride_id=ride.ride_id,
    )
    record_event(uow, "ride.stranded", ride.ride_id, "", detail)
    uow.publish(topics.ride(uow.campus_id, ride.ride_id))
