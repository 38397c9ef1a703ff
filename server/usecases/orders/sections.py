"""Grants the road ahead. Every grant and every route goes through the reservation controller."""

import math
from collections.abc import Mapping
from dataclasses import replace

from contract.geometry import Pose2
from contract.wire.messages import SectionGrant
from server.domain.fleet.vehicles import Vehicle
from server.domain.orders.orders import IssuedOrder, OrderState
from server.domain.orders.sections import HeldSection, Occupancy
from server.domain.planning.plans import Plan, PlannedVisit
from server.travel.fleet_roads import FleetRoads
from server.usecases.orders import orders
from server.usecases.orders.order_payload import grants_on_the_wire
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.server_events import record_event
from server.usecases.roads.road_positions import road_position, sections_to_request
from server.usecases.roads.section_reservations import SectionReservations

# With no other shuttle within this distance, a shuttle gets so many times as much road ahead.
ALONE_M = 200.0
ALONE_FACTOR = 2.0


def extend_grants(uow: UnitOfWork) -> tuple[str, ...]:
    """Retry routes that were not safe, then grant the road ahead. Returns the vehicles with new grants."""
    reservations = SectionReservations(uow)
    for vehicle in uow.vehicles.all():
        if vehicle.placed:
            orders.reissue(uow, vehicle.vehicle_id, reservations)
    return grant_ahead(uow, reservations)


def grant_ahead(uow: UnitOfWork, reservations: SectionReservations) -> tuple[str, ...]:
    """Grant the road ahead to every vehicle that can drive. Returns the vehicles with new grants."""
    gained: list[str] = []
    poses = {
        where.vehicle_id: where.status.pose_map
        for where in uow.vehicles.all_whereabouts()
        if where.status is not None
    }
    for vehicle in uow.vehicles.all():
        if vehicle.placed and vehicle.connected and not vehicle.held:
            count = _wanted(uow, vehicle, reservations, poses)
            if count and reservations.grant(vehicle.vehicle_id, count):
                gained.append(vehicle.vehicle_id)
                uow.publish(topics.vehicle_outbox(uow.campus_id, vehicle.vehicle_id))
    return tuple(gained)


def grants_of(uow: UnitOfWork, vehicle_id: str) -> tuple[SectionGrant, ...]:
    """What the vehicle holds, in route order."""
    return grants_on_the_wire(SectionReservations(uow), vehicle_id)


def released(uow: UnitOfWork, vehicle_id: str, section_id: str, fence: int) -> None:
    """The vehicle has left a section: the routes and grants of others are tried again.

    One that has left its only section is somewhere else. It keeps that section until a position of it,
    standing, places it again.
    """
    held = uow.sections.held_by(vehicle_id)
    if HeldSection(section_id, fence) not in held:
        return  # without rebuilding the reservations of the whole fleet
    if len(held) == 1:
        uow.vehicles.save(replace(enrolled_vehicle(uow, vehicle_id), placed=False))
        record_event(uow, "vehicle.left_its_sections", vehicle_id, vehicle_id, section_id)
        uow.publish(topics.vehicle(uow.campus_id, vehicle_id))
        return
    if SectionReservations(uow).release(vehicle_id, section_id, fence):
        extend_grants(uow)


def _wanted(
    uow: UnitOfWork, vehicle: Vehicle, reservations: SectionReservations, poses: Mapping[str, Pose2]
) -> int:
    occupancy = reservations.occupancy(vehicle.vehicle_id)
    if not occupancy.ahead:
        return 0
    where = uow.vehicles.whereabouts(vehicle.vehicle_id)
    if where is None or where.status is None:
        return 0
    is_alone = _is_alone(vehicle.vehicle_id, poses)
    distance_m = uow.rules.grant_ahead_m * (ALONE_FACTOR if is_alone else 1.0)
    plan, order = uow.plans.get(vehicle.vehicle_id), uow.orders.current(vehicle.vehicle_id)
    roads, status = uow.roads(), where.status

    def count() -> int:
        here = road_position(roads.network, occupancy.held_ids, status)
        ahead = _open_ahead(roads, occupancy)
        halt = _next_halt(plan, order)
        return sections_to_request(roads.network, occupancy.held_ids, ahead, here, distance_m, halt)

    name = f"wanted {is_alone} {vehicle.vehicle_id}"
    return roads.results.get(name, (occupancy, status, plan, order, uow.rules), count)


def _open_ahead(roads: FleetRoads, occupancy: Occupancy) -> tuple[str, ...]:
    """The road ahead, up to the first closed section."""
    if not roads.closed:
        return occupancy.ahead
    shut = roads.access.closed_for(occupancy.held_ids[-1])
    first = next((n for n, section_id in enumerate(occupancy.ahead) if section_id in shut), None)
    return occupancy.ahead[:first]


def _next_halt(plan: Plan | None, order: IssuedOrder | None) -> PlannedVisit | None:
    """The first visit of the order in force that is still to be made."""
    if plan is None or order is None or order.state is OrderState.DONE:
        return None
    ordered = {visit.visit_id for visit in order.payload.visits}
    return next((visit for visit in plan.visits if visit.visit_id in ordered), None)


def _is_alone(vehicle_id: str, poses: Mapping[str, Pose2]) -> bool:
    mine = poses[vehicle_id]
    return all(
        math.hypot(pose.x_m - mine.x_m, pose.y_m - mine.y_m) > ALONE_M
        for other_id, pose in poses.items()
        if other_id != vehicle_id
    )
