"""Stores decided routes as plans by compare and set, and sends them as orders if that is safe."""

from collections.abc import Iterable, Sequence

from server.dispatch.problem import VehicleRoute
from server.usecases.orders import orders, sections
from server.usecases.planning.routes import differs_from_plan, save_route
from server.usecases.planning.snapshot import Snapshot
from server.usecases.ports.unit_of_work import UnitOfWork


def adopt_routes(uow: UnitOfWork, snapshot: Snapshot, routes: Iterable[VehicleRoute]) -> tuple[str, ...]:
    """Store routes that differ from the plans, and issue safe orders. Returns the changed vehicles.

    Raises PlanChanged, NoRestingPlaceFree.
    """
    changed = []
    for route in routes:
        if differs_from_plan(snapshot.plans[route.vehicle_id], route):
            save_route(uow, snapshot, route)
            changed.append(route.vehicle_id)
    issue_orders(uow, snapshot, changed)
    return tuple(changed)


def issue_orders(uow: UnitOfWork, snapshot: Snapshot, vehicle_ids: Sequence[str]) -> None:
    """Give these vehicles new orders as soon as their routes are safe."""
    for vehicle_id in vehicle_ids:
        orders.reissue(uow, vehicle_id, snapshot.reservations)
    if vehicle_ids:
        sections.grant_ahead(uow, snapshot.reservations)
