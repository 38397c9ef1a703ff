"""Converts the server's domain objects to scene objects, one function for each."""

from collections.abc import Collection, Mapping

import msgspec

from contract.geometry import Pose2
from contract.roads.model import Point
from contract.wire.messages import Status
from server.domain.fleet.vehicles import Vehicle, VehicleCommand
from server.domain.instants import ms_of
from server.domain.planning.outlooks import NO_OUTLOOK, RideOutlook
from server.domain.planning.plans import PlannedVisit
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.rides.rides import Ride
from server.domain.rules import FleetRules
from server.live.route_shape import RouteShapes
from server.live.scene import (
    CommandScene,
    IncidentsScene,
    RideScene,
    VehicleFacts,
    VehicleScene,
    VehicleTask,
    VisitScene,
)
from server.usecases.ports.views import VehicleView


def vehicle_scene(
    view: VehicleView,
    shapes: RouteShapes | None,
    parties: Mapping[str, int],
    rules: FleetRules,
    chargers: Collection[str] = (),
) -> VehicleScene:
    """A vehicle from the store.

    parties   people of the rides that may be aboard, by ride id
    chargers  the resting places that charge, by place id
    """
    scene = VehicleScene(
        view.vehicle.vehicle_id,
        vehicle_facts(view.vehicle),
        _task(view, shapes, parties, rules, chargers),
        command=None if view.last_command is None else command_scene(view.last_command),
    )
    if view.status is None:
        return scene
    return with_status(scene, view.status, ms_of(view.heard_at))


def vehicle_facts(vehicle: Vehicle) -> VehicleFacts:
    """The facts have the domain's field names: every field of both types is shown."""
    return msgspec.convert(vehicle, VehicleFacts, from_attributes=True)


def command_scene(command: VehicleCommand) -> CommandScene:
    return CommandScene(
        command.command_id, command.kind, command.state, command.detail, command.by, ms_of(command.made_at)
    )


def with_status(scene: VehicleScene, status: Status, heard_ms: int) -> VehicleScene:
    """The vehicle with its newest status, rounded to what a screen can show."""
    pose = status.pose_map
    rounded = msgspec.structs.replace(
        status,
        pose_map=Pose2(round(pose.x_m, 3), round(pose.y_m, 3), round(pose.yaw_rad, 4)),
        speed_mps=round(status.speed_mps, 3),
        accel_mps2=round(status.accel_mps2, 3),
        steer_rad=round(status.steer_rad, 4),
        s_m=round(status.s_m, 2),
        battery_ratio=round(status.battery_ratio, 3),
        obstacle_m=None if status.obstacle_m is None else round(status.obstacle_m, 2),
    )
    return msgspec.structs.replace(scene, status=rounded, heard_ms=heard_ms)


def _task(
    view: VehicleView,
    shapes: RouteShapes | None,
    parties: Mapping[str, int],
    rules: FleetRules,
    chargers: Collection[str],
) -> VehicleTask:
    visits = [visit for visit in view.plan.visits if visit.is_open]
    status = view.status
    route: tuple[Point, ...] = ()
    if shapes is not None and status is not None and view.route and visits:
        route = shapes.ahead(view.route, visits[-1].s_m, status.lane_id, status.s_m)
    return VehicleTask(
        next_stop=next((visit.stop_id for visit in visits if visit.stop_id), ""),
        people_aboard=0 if status is None else sum(parties.get(ride_id, 0) for ride_id in status.aboard),
        at_charger=not visits and view.plan.resting_place_id in chargers,
        route=route,
        visits=tuple(_visit(visit) for visit in visits),
        order_waits=view.order_waits,
        hold_ends_ms=ms_of(view.vehicle.hold_ends),
        charged_at_ms=ms_of(view.charged_at(rules)),
        unavailable_since_ms=ms_of(view.vehicle.unavailable_since),
    )


def _visit(visit: PlannedVisit) -> VisitScene:
    return VisitScene(
        visit.visit_id,
        visit.kind,
        visit.state,
        visit.stop_id,
        len(visit.board),
        len(visit.alight),
        ms_of(visit.eta),
        visit.why,
    )


def ride_scene(ride: Ride, state: str | None = None, outlook: RideOutlook = NO_OUTLOOK) -> RideScene:
    """state: a former state of the ride, for replay, which has no outlook."""
    promise, pickup, arrival = ride.promise, outlook.pickup, outlook.arrival
    return RideScene(
        ride_id=ride.ride_id,
        ride_code=ride.ride_code,
        state=state or ride.state.value,
        from_stop=ride.from_stop,
        to_stop=ride.to_stop,
        party=ride.party,
        vehicle_id=ride.vehicle_id or "",
        pickup_from_ms=ms_of(promise.pickup_from if promise else None),
        pickup_to_ms=ms_of(promise.pickup_to if promise else None),
        arrive_by_ms=ms_of(promise.arrive_by if promise else None),
        pickup_eta_ms=ms_of(ride.pickup_eta),
        arrival_eta_ms=ms_of(ride.arrival_eta),
        reason=ride.reason,
        pickup_earliest_ms=ms_of(pickup.earliest if pickup else None),
        pickup_latest_ms=ms_of(pickup.latest if pickup else None),
        seats_left=outlook.seats_left,
        arrival_earliest_ms=ms_of(arrival.earliest if arrival else None),
        arrival_latest_ms=ms_of(arrival.latest if arrival else None),
    )


def incidents_scene(open_ones: tuple[Incident, ...], serial: int) -> IncidentsScene:
    return IncidentsScene(
        open=len(open_ones),
        unacknowledged=sum(incident.acknowledged_at is None for incident in open_ones),
        help_calls=sum(incident.kind is IncidentKind.HELP_CALL for incident in open_ones),
        serial=serial,
    )
