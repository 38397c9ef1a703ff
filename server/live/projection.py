"""From the server's nouns to what a screen shows: one function each way in."""

from collections.abc import Collection, Mapping
from datetime import UTC, datetime, timedelta

import msgspec

from contract.wire.messages import Status
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.rides.rides import Ride
from server.live.route_shape import RouteShapes
from server.live.scene import IncidentsScene, RideScene, VehicleScene
from server.usecases.ports.views import VehicleView

EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def ms_of(moment: datetime | None) -> int:
    """Milliseconds since the Unix epoch; 0 for None."""
    return 0 if moment is None else (moment - EPOCH) // timedelta(milliseconds=1)


def vehicle_scene(
    view: VehicleView,
    shapes: RouteShapes | None,
    parties: Mapping[str, int],
    chargers: Collection[str] = (),
) -> VehicleScene:
    """A vehicle from the store.

    parties   people of the rides that may be aboard, by ride id
    chargers  the resting places that charge, by place id
    """
    vehicle, status = view.vehicle, view.status
    visits = [visit for visit in view.plan.visits if visit.is_open]
    scene = VehicleScene(
        vehicle_id=vehicle.vehicle_id,
        name=vehicle.name,
        seats=vehicle.seats,
        connected=vehicle.connected,
        held=vehicle.held,
        in_service=vehicle.in_service,
        mode=vehicle.mode,
        next_stop=next((visit.stop_id for visit in visits if visit.stop_id), ""),
        charging=not visits and view.plan.resting_place_id in chargers,
    )
    if status is None:
        return scene
    people = sum(parties.get(ride_id, 0) for ride_id in status.aboard)
    scene = msgspec.structs.replace(scene, people_aboard=people)
    if shapes is not None and view.route and visits:
        route = shapes.ahead(view.route, visits[-1].s_m, status.lane_id, status.s_m)
        scene = msgspec.structs.replace(scene, route=route)
    return vehicle_in_status(scene, status, ms_of(view.heard_at))


def vehicle_in_status(scene: VehicleScene, status: Status, heard_ms: int) -> VehicleScene:
    """The vehicle where its newest status puts it; what the status does not know stays."""
    pose = status.pose_map
    return msgspec.structs.replace(
        scene,
        x_m=round(pose.x_m, 3),
        y_m=round(pose.y_m, 3),
        yaw_rad=round(pose.yaw_rad, 4),
        speed_mps=round(status.speed_mps, 3),
        located=True,
        mode=status.mode,
        heard_ms=heard_ms,
        battery_ratio=round(status.battery_ratio, 3),
        doors_open=status.doors_open,
        obstacle_m=None if status.obstacle_m is None else round(status.obstacle_m, 2),
        waiting_for=status.waiting_for,
        screen=status.screen,
        spoken=status.spoken,
        order_id=status.order_id,
        visit_id=status.visit_id,
        aboard=status.aboard,
        faults=tuple(fault.code for fault in status.faults),
        driving=status.driving,
    )


def ride_scene(ride: Ride, state: str | None = None) -> RideScene:
    """state: another one than the ride's present, for replay."""
    promise = ride.promise
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
    )


def incidents_scene(open_ones: tuple[Incident, ...], serial: int) -> IncidentsScene:
    return IncidentsScene(
        open=len(open_ones),
        unacknowledged=sum(incident.acknowledged_at is None for incident in open_ones),
        help_calls=sum(incident.kind is IncidentKind.HELP_CALL for incident in open_ones),
        serial=serial,
    )
