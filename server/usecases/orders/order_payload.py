"""A plan as it goes over the wire."""

from collections.abc import Sequence
from datetime import timedelta

import msgspec

from contract.wire.messages import Order, RiderTask, SectionGrant, Visit
from server.domain.fleet.vehicles import Vehicle
from server.domain.instants import ns_of
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.rides.rides import Ride
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.roads.section_reservations import SectionReservations


def order_payload(
    uow: UnitOfWork,
    vehicle: Vehicle,
    plan: Plan,
    legs: Sequence[tuple[str, ...]],
    order_id: str,
    revision: int,
    reservations: SectionReservations,
) -> Order:
    """The order as it is stored: without boarding codes, see `with_codes`.

    legs  the lanes to each of the plan's visits
    """
    return Order(
        epoch=vehicle.epoch,
        order_id=order_id,
        revision=revision,
        map_version=uow.network().map_version,
        visits=tuple(_visit(uow, visit, leg) for visit, leg in zip(plan.ordered, legs, strict=True)),
        sections=grants_on_the_wire(reservations, vehicle.vehicle_id),
        expires_ns=expiry_ns(uow),
    )


def grants_on_the_wire(reservations: SectionReservations, vehicle_id: str) -> tuple[SectionGrant, ...]:
    """What the vehicle holds, in route order."""
    return tuple(SectionGrant(s.section_id, s.fence) for s in reservations.occupancy(vehicle_id).held)


def _visit(uow: UnitOfWork, visit: PlannedVisit, leg: tuple[str, ...]) -> Visit:
    stop = uow.network().stops.get(visit.stop_id)
    return Visit(
        visit_id=visit.visit_id,
        kind=visit.kind,
        stop_id=visit.stop_id,
        lane_id=visit.lane_id,
        s_m=visit.s_m,
        route=leg,
        board=_tasks(uow, visit.board),
        alight=_tasks(uow, visit.alight),
        dwell_s=visit.dwell_s,
        not_before_ns=0 if visit.not_before is None else ns_of(visit.not_before),
        timed=bool(visit.departure_id),
        name="" if stop is None else stop.name,
        name_en="" if stop is None else stop.name_en,
    )


def _tasks(uow: UnitOfWork, ride_ids: tuple[str, ...]) -> tuple[RiderTask, ...]:
    rides = (uow.rides.get(ride_id) for ride_id in ride_ids)
    return tuple(RiderTask(ride.ride_id, ride.party) for ride in rides if ride)


def with_codes(uow: UnitOfWork, order: Order) -> Order:
    """The order as it is sent: each rider's task with the boarding code."""
    visits = tuple(
        msgspec.structs.replace(
            visit, board=_with_codes(uow, visit.board), alight=_with_codes(uow, visit.alight)
        )
        for visit in order.visits
    )
    return msgspec.structs.replace(order, visits=visits)


def _with_codes(uow: UnitOfWork, tasks: tuple[RiderTask, ...]) -> tuple[RiderTask, ...]:
    return tuple(
        task if ride is None else msgspec.structs.replace(task, code=_code(uow, ride))
        for task, ride in ((task, uow.rides.get(task.ride_id)) for task in tasks)
    )


def _code(uow: UnitOfWork, ride: Ride) -> str:
    return uow.tickets.ride_secrets(ride.ticket_key_id, ride.ride_id).boarding_code


def expiry_ns(uow: UnitOfWork) -> int:
    """The time until which a vehicle may accept what is sent now."""
    return ns_of(uow.now + timedelta(seconds=uow.rules.order_valid_s))
