"""Takes over what vehicles report about their visits; it overrides the plan."""

import math
from collections.abc import Iterable
from dataclasses import replace

import msgspec

from contract.geometry import Pose2
from contract.wire.messages import VisitProgress, VisitState
from server.domain.errors import IllegalTransition
from server.domain.orders.orders import OrderState
from server.domain.planning.plans import Plan, PlannedVisit, with_visit_state
from server.domain.rides.rides import RideState, moved
from server.domain.service.timetable import DepartureState
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import travel_time_factors
from server.usecases.record.server_events import record_event

NEAR_M = 15.0


def change(uow: UnitOfWork, vehicle_id: str, visit_id: str, state: VisitState) -> PlannedVisit | None:
    """Take over one visit's state. Returns the visit, or None if nothing changed.

    A visit cannot go back: the plan keeps the later state.
    """
    plan = uow.plans.get(vehicle_id)
    if plan is None:
        return None
    try:
        after = with_visit_state(plan, visit_id, state)
    except IllegalTransition as error:
        record_event(uow, "visit.backwards", vehicle_id, "", error.detail)
        return None
    if after is plan:
        return None
    uow.plans.save(after, plan.version)
    follow(uow, plan, after)
    visit = plan.visit(visit_id)
    if visit is not None:
        _measure_leg(uow, vehicle_id, visit, state)
        if state != "skipped":
            _move_position_to(uow, vehicle_id, visit)
        _publish_state(uow, vehicle_id, visit, state)
    return visit


def take_over(uow: UnitOfWork, vehicle_id: str, progress: Iterable[VisitProgress]) -> None:
    """Take over all visit states that a vehicle reports, in its order."""
    for visit in progress:
        if visit.state != "pending":
            change(uow, vehicle_id, visit.visit_id, visit.state)


def follow(uow: UnitOfWork, before: Plan, after: Plan) -> None:
    """After a vehicle's report, mark the order as up to date with the plan: it needs no revision for that.

    An order that the vehicle has not accepted yet does, if it still names a completed visit.
    """
    order = uow.orders.current(before.vehicle_id)
    if order is None or order.plan_version != before.version or order.state is OrderState.DONE:
        return
    ordered = {visit.visit_id for visit in order.payload.visits}
    open_now = {visit.visit_id for visit in after.visits}
    if not ordered & open_now:
        uow.orders.save(replace(order, plan_version=after.version, state=OrderState.DONE))
    elif order.state is OrderState.ACCEPTED or ordered <= open_now:
        uow.orders.save(replace(order, plan_version=after.version))


def _measure_leg(uow: UnitOfWork, vehicle_id: str, visit: PlannedVisit, state: VisitState) -> None:
    """Record how long the fleet drives from stop to stop, for the plans of other days."""
    if state == "under_way":
        travel_time_factors.arrived(uow, vehicle_id, visit)
    elif state == "done":
        travel_time_factors.left(uow, vehicle_id, visit)


def _move_position_to(uow: UnitOfWork, vehicle_id: str, visit: PlannedVisit) -> None:
    """Move the stored position to the visit: positions come in batches and may be older.

    A position farther away is not changed: the event is old and came late.
    """
    where = uow.vehicles.whereabouts(vehicle_id)
    if where is None or where.status is None:
        return
    pose = where.status.pose_map
    x_m, y_m, yaw_rad = uow.network().pose(visit.lane_id, visit.s_m)
    if math.hypot(pose.x_m - x_m, pose.y_m - y_m) <= NEAR_M:
        stands = msgspec.structs.replace(
            where.status,
            pose_map=Pose2(x_m, y_m, yaw_rad),
            lane_id=visit.lane_id,
            s_m=visit.s_m,
            speed_mps=0.0,
        )
        uow.vehicles.save_position(vehicle_id, stands)


def _publish_state(uow: UnitOfWork, vehicle_id: str, visit: PlannedVisit, state: VisitState) -> None:
    if state == "under_way":
        for ride_id in visit.board:
            ride = uow.rides.get(ride_id)
            if ride is not None and ride.state is RideState.ASSIGNED and ride.vehicle_id == vehicle_id:
                uow.rides.save(moved(ride, RideState.BOARDING))
                uow.publish(topics.ride(uow.campus_id, ride_id), vehicle_id=vehicle_id)
    elif state == "done" and visit.departure_id:
        _complete_call(uow, visit)
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id), visit_id=visit.visit_id, visit_state=state)


def _complete_call(uow: UnitOfWork, visit: PlannedVisit) -> None:
    departure = uow.departures.get(visit.departure_id)
    if departure is not None and visit.call == len(departure.calls) - 1:
        uow.departures.save(replace(departure, state=DepartureState.DONE))
