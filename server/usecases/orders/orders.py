"""Turns plans into orders on the wire, and handles the vehicle's answers."""

from dataclasses import replace
from datetime import timedelta

from contract.wire.messages import OrderRejected
from server.domain.errors import OrderUnknown
from server.domain.fleet.vehicles import STANDS_MPS, Vehicle
from server.domain.instants import ns_of
from server.domain.orders.orders import IssuedOrder, OrderState
from server.domain.planning.plans import Plan
from server.domain.record.incidents import IncidentKind
from server.usecases.orders import visits
from server.usecases.orders.order_payload import order_payload
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import record_event
from server.usecases.roads.road_positions import RoadPosition, road_position
from server.usecases.roads.routing import (
    DrivingRoute,
    blocked_for,
    leads_through_closed,
    way_through,
)
from server.usecases.roads.section_reservations import SectionReservations

REJECTIONS_MAX = 3


def reissue(
    uow: UnitOfWork, vehicle_id: str, reservations: SectionReservations | None = None
) -> IssuedOrder | None:
    """Issue an order for the vehicle's plan, if its new route is safe now; None if nothing changed.

    While the route is not safe the old order stays in force; the next release tries again.
    Raises VehicleUnknown.
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    plan = uow.plans.get(vehicle_id)
    present = uow.orders.current(vehicle_id)
    if plan is None or not plan.ordered or not vehicle.placed:
        return None
    if uow.roads().closed:
        reservations = reservations or SectionReservations(uow)
    turns = reservations is not None and leads_through_closed(uow.roads(), reservations, vehicle_id)
    turns = turns or _waits_off_its_route(uow, vehicle_id, present, reservations)
    if not turns and not _is_behind(present, plan):
        return None
    if not turns and present is not None and _says_the_same(present, plan):
        uow.orders.save(replace(present, plan_version=plan.version))
        return None
    where = uow.vehicles.whereabouts(vehicle_id)
    if where is None or where.status is None:
        return None
    reservations = reservations or SectionReservations(uow)
    held = reservations.occupancy(vehicle_id).held_ids
    here = road_position(uow.network(), held, where.status)
    if _is_held_back(uow, plan, present, here):
        return None
    way = _way(uow, plan, present, reservations, here, where.status.speed_mps)
    if way is None or not reservations.adopt(vehicle_id, way.sections):
        return None
    return _issue(uow, vehicle, plan, present, way, reservations)


def accepted(uow: UnitOfWork, vehicle_id: str, order_id: str, revision: int) -> None:
    """The vehicle has it on disk. A repeat is harmless. Raises OrderUnknown."""
    order = _found(uow, vehicle_id, order_id, revision)
    if order.state in (OrderState.ISSUED, OrderState.REJECTED):
        uow.orders.save(replace(order, state=OrderState.ACCEPTED, reason=""))
        clear_incident(uow, IncidentKind.ORDER_REJECTED, vehicle_id)
        uow.publish(topics.vehicle(uow.campus_id, vehicle_id))


def rejected(uow: UnitOfWork, vehicle_id: str, answer: OrderRejected) -> IssuedOrder | None:
    """The vehicle keeps its previous order: take over its visit states and issue another revision.

    An order that arrived too late is sent again unchanged. Repeated rejections open an incident, and then
    only a changed plan is tried. Raises OrderUnknown.
    """
    order = _found(uow, vehicle_id, answer.order_id, answer.revision)
    present = uow.orders.current(vehicle_id)
    is_present = present is not None and (present.order_id, present.revision) == (
        order.order_id,
        order.revision,
    )
    if not is_present or order.state is not OrderState.ISSUED or answer.code == "expired":
        return None
    uow.orders.save(replace(order, state=OrderState.REJECTED, reason=answer.code))
    cause = f"{answer.code}: {answer.detail}"
    record_event(uow, "order.rejected", vehicle_id, "", cause)
    visits.take_over(uow, vehicle_id, answer.visits)
    if _rejections(uow, order, answer.code) >= REJECTIONS_MAX:
        open_incident(uow, IncidentKind.ORDER_REJECTED, vehicle_id, cause, vehicle_id=vehicle_id)
        return None
    return repeat(uow, vehicle_id)


def retry_rejected(uow: UnitOfWork, vehicle_id: str) -> IssuedOrder | None:
    """Issue a rejected order again: the vehicle has left the visit for whose sake it rejected it."""
    order = uow.orders.current(vehicle_id)
    if order is None or order.state is not OrderState.REJECTED:
        return None
    return repeat(uow, vehicle_id)


def withdraw(uow: UnitOfWork, vehicle_id: str) -> None:
    """The vehicle does not have the present order and will not get it: the next order gets a new id."""
    order = uow.orders.current(vehicle_id)
    if order is not None and order.state is not OrderState.DONE:
        uow.orders.save(replace(order, state=OrderState.DONE, reason="withdrawn", plan_version=-1))


def repeat(uow: UnitOfWork, vehicle_id: str) -> IssuedOrder | None:
    """Issue the plan again as a new revision from where the vehicle is now."""
    order = uow.orders.current(vehicle_id)
    if order is not None and order.state is not OrderState.DONE:
        uow.orders.save(replace(order, plan_version=-1))
    return reissue(uow, vehicle_id)


def visits_removed(uow: UnitOfWork, before: Plan, after: Plan) -> None:
    """The server has changed a plan: an order that names a visit which is no longer in it must be replaced.

    Otherwise the vehicle would drive to a stop for riders who have cancelled or got off.
    """
    order = uow.orders.current(before.vehicle_id)
    if order is None or order.state is OrderState.DONE:
        return
    kept = {visit.visit_id for visit in after.visits}
    removed = {visit.visit_id for visit in before.visits if visit.visit_id not in kept}
    if not removed.isdisjoint(_visit_ids(order)):
        uow.orders.save(replace(order, plan_version=-1))


# ---------------------------------------------------------------- making an order


def _waits_off_its_route(
    uow: UnitOfWork, vehicle_id: str, present: IssuedOrder | None, reservations: SectionReservations | None
) -> bool:
    """The vehicle stands before a section that is not the next of its route here: it would never be granted.

    An order made from an older position leads a vehicle that has passed the visit meanwhile another way, or
    round a loop once less.
    """
    if present is None or present.state is not OrderState.ACCEPTED or reservations is None:
        return False
    where = uow.vehicles.whereabouts(vehicle_id)
    status = None if where is None else where.status
    if status is None or not status.waiting_for or status.speed_mps > STANDS_MPS:
        return False
    if (status.order_id, status.revision) != (present.order_id, present.revision):
        return False
    occupancy = reservations.occupancy(vehicle_id)
    return status.waiting_for not in (*occupancy.held_ids, *occupancy.ahead[:1])


def _is_behind(present: IssuedOrder | None, plan: Plan) -> bool:
    """The plan has changed since the present order was made."""
    return present is None or present.plan_version != plan.version


def _says_the_same(present: IssuedOrder, plan: Plan) -> bool:
    """The plan has changed only behind the visits of the order: no new revision is needed.

    In which order the parties of one visit are named means nothing, and each improvement may change it.
    """
    if present.state not in (OrderState.ISSUED, OrderState.ACCEPTED) or present.plan_version < 0:
        return False
    ahead = plan.ordered
    held = present.payload.visits[-len(ahead) :]
    return len(held) == len(ahead) and all(
        (sent.visit_id, sent.dwell_s, sent.not_before_ns)
        == (visit.visit_id, visit.dwell_s, 0 if visit.not_before is None else ns_of(visit.not_before))
        and {task.ride_id for task in sent.board} == set(visit.board)
        and {task.ride_id for task in sent.alight} == set(visit.alight)
        for sent, visit in zip(held, ahead, strict=True)
    )


def _is_held_back(uow: UnitOfWork, plan: Plan, present: IssuedOrder | None, here: RoadPosition) -> bool:
    """A resting vehicle whose first visit is timed must not leave yet: it would block the road.

    A party that gets off there does not wait for the one that boards.
    """
    first = plan.visits[0]
    at_rest = present is None or present.state is OrderState.DONE
    if not at_rest or first.alight or first.not_before is None or first.stop_id == "":
        return False
    roads = uow.roads()
    own = frozenset({plan.resting_place_id})
    row = roads.times_to_stops((here.lane_id, here.s_m), own, frozenset())
    drive_s = uow.travel_time_factor_at(first.not_before) * float(row[roads.stop_numbers[first.stop_id]])
    early_s = uow.rules.early_s(timed=bool(first.departure_id))
    leave_at = first.not_before - timedelta(seconds=first.dwell_s + drive_s + early_s)
    return uow.now < leave_at


def _way(
    uow: UnitOfWork,
    plan: Plan,
    present: IssuedOrder | None,
    reservations: SectionReservations,
    here: RoadPosition,
    speed_mps: float,
) -> DrivingRoute | None:
    roads, rules = uow.roads(), uow.rules
    occupancy = reservations.occupancy(plan.vehicle_id)
    going = present is not None and present.state is not OrderState.DONE
    heading_for = ""
    if going and present is not None and plan.visits[0].visit_id in _visit_ids(present):
        heading_for = plan.visits[0].visit_id
    others = {p.resting_place_id for p in uow.plans.all() if p.vehicle_id != plan.vehicle_id}
    unreserved = frozenset(roads.network.resting_places) - others
    for own in (frozenset({plan.resting_place_id}), unreserved):
        way = way_through(
            roads,
            occupancy.held_ids,
            here,
            plan.ordered,
            blocked_for(roads, own, occupancy.held_ids, occupancy.ahead),
            stopping_m=rules.stopping_m(speed_mps),
            heading_for=heading_for,
        )
        if way is not None:
            return way
    return None


def _issue(
    uow: UnitOfWork,
    vehicle: Vehicle,
    plan: Plan,
    present: IssuedOrder | None,
    way: DrivingRoute,
    reservations: SectionReservations,
) -> IssuedOrder:
    continues = present is not None and present.state is not OrderState.DONE
    order_id = present.order_id if continues and present is not None else uow.ids.new_id("order")
    revision = present.revision + 1 if continues and present is not None else 1
    payload = order_payload(uow, vehicle, plan, way.legs, order_id, revision, reservations)
    order = IssuedOrder(
        campus_id=uow.campus_id,
        vehicle_id=vehicle.vehicle_id,
        order_id=order_id,
        revision=revision,
        plan_version=plan.version,
        state=OrderState.ISSUED,
        payload=payload,
        issued_at=uow.now,
    )
    uow.orders.add(order)
    uow.publish(topics.vehicle_outbox(uow.campus_id, vehicle.vehicle_id))
    uow.publish(topics.vehicle(uow.campus_id, vehicle.vehicle_id))
    return order


def _found(uow: UnitOfWork, vehicle_id: str, order_id: str, revision: int) -> IssuedOrder:
    order = uow.orders.find(vehicle_id, order_id, revision)
    if order is None:
        raise OrderUnknown(f"{vehicle_id} names order {order_id}/{revision}, which was never issued")
    return order


def _rejections(uow: UnitOfWork, last: IssuedOrder, reason: str) -> int:
    """How many revisions in a row, up to this one, were rejected for the same reason."""
    count = 1
    while count < REJECTIONS_MAX:
        earlier = uow.orders.find(last.vehicle_id, last.order_id, last.revision - count)
        if earlier is None or earlier.state is not OrderState.REJECTED or earlier.reason != reason:
            return count
        count += 1
    return count


def _visit_ids(order: IssuedOrder) -> frozenset[str]:
    return frozenset(visit.visit_id for visit in order.payload.visits)
